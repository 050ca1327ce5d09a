qs-path walk --bounds 0,0,0,1 --frames 99
