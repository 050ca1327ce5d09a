qs-info
