qs-path orbit --bounds 0,0,1
