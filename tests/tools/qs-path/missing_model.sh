qs-path orbit scan.ply
