qs-path dolly --bounds 0,0,0,1 --near-factor 2 --far-factor 2
