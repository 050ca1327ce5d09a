qs-path orbit --bounds 0,0,0,1 --frames 0
