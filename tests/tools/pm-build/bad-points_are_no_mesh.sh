"$QS_SOURCE/tests/tools/expect-refusal" pm-build "$QS_DATA/mesh-cloud.ply" -o model.pm
cp "$QS_DATA/mesh-cloud.ply" .
pm-build mesh-cloud.ply -o model.pm
