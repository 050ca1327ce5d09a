qs-path orbit --bounds 0,0,0,1 --up w
