// hoodoo_write_vdb FILE RADIUS VOXEL X Y Z   the level set of a ball, for tests that drive the
// command hoodoo_write_vdb FILE                      the example schema/nodes/grid.vdb
#include <cstdio>
#include <cstdlib>

#include "tests/engine/scene/vdb_writer.hpp"

int main(int count, char** arguments) {
  using namespace hoodoo::scene;
  if (count == 2) {
    write_sponge(arguments[1]);
  } else if (count == 7) {
    const auto number = [&](int i) { return std::strtod(arguments[i], nullptr); };
    write_ball(arguments[1], {number(4), number(5), number(6)}, number(2),
               {.name = "ball", .voxel = number(3)});
  } else {
    std::fputs("hoodoo_write_vdb FILE [RADIUS VOXEL X Y Z]\n", stderr);
    return 2;
  }
}
