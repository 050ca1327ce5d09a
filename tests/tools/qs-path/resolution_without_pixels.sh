qs-path orbit --bounds 0,0,0,1 --resolution 640,0
