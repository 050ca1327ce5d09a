qs-path
