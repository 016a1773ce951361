#!/usr/bin/env bash
# Installs what is missing, builds hoodoo and bakes the bundled example into build/first-light.
set -euo pipefail
cd "$(dirname "$0")/.."

example=schema/examples/first-light
hoodoo=build/release/hoodoo

deploy/setup.sh --build
cmake --preset release
cmake --build --preset release --target hoodoo
$hoodoo synthesize $example/dem.tif
$hoodoo bake $example/scene.json -o build/first-light
$hoodoo verify build/first-light

cat <<EOF

The tileset is build/first-light/tileset.json. To look at it:

  $hoodoo serve --root $example

and POST the scene, as README.md shows.
EOF
