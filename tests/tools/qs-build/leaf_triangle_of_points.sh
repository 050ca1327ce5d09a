cp "$QS_DATA/mesh-cloud.ply" cloud.ply
qs-build cloud.ply --leaf triangle -o model.qs
