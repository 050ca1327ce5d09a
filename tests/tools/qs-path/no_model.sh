qs-path orbit
