qs-path orbit scan.ply --bounds 0,0,0,1
