# The stages of a bake in the order of the data flow. A stage may use only those above it: the root
# CMakeLists.txt declares them in this order, and tests/layering holds every include to it.
set(HOODOO_STAGES
  engine/base
  engine/dem
  engine/hydrology
  engine/tree
  engine/generator
  engine/scene
  tiling/plan
  tiling/slice
  tiling/volume
  tiling/surface
  tiling/lod
  tiling/glb
  tiling/store
  tiling/tileset
  tiling/compare
  tiling/archive
  tiling/export
  tiling/bake
  server/asset
  server/job
  server/http)
