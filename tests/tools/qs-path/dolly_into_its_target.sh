# The target is far from the bounds: at its coordinates a double cannot tell the eye from it.
qs-path dolly --bounds 0,0,0,1 --target 1e20,0,0
