#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "engine/base/random.hpp"
#include "engine/base/vector.hpp"
#include "tiling/surface/surface.hpp"
#include "tiling/volume/volume.hpp"

/// Lattices to triangulate: what is solid and where its edges are crossed, for the whole of space.
namespace hoodoo::surface::testing {

using volume::Crossing;
using volume::Index;

struct Lattice {
  std::function<bool(const Index&)> solid;
  std::function<Crossing(int axis, const Index& low)> crossing;
  std::function<bool(std::int64_t i, std::int64_t j)> in_world = [](auto, auto) { return true; };
};

/// Solid where f > 0, one unit of length per cell. Crossings by bisection, normals by central
/// differences, material 0.
using Function = std::function<double(const Vec3&)>;
Lattice lattice_of(Function f);
Vec3 gradient(const Function& f, const Vec3& p);
/// From `p` to the nearest point where f = 0 that Newton's method finds.
double distance_to_surface(const Function& f, const Vec3& p);

/// Signs, crossings (some exactly at an end), normals and two materials at random. `roughness` of
/// the points differ from the pattern: 0 all air, 1 a checkerboard, 2 a checkerboard in plan.
Lattice random_lattice(std::uint64_t seed, double roughness, int pattern, double holes);

enum class Store { mixed_blocks, every_block };
volume::Volume fill(const Lattice& lattice, const Index& low, const Index& high,
                    Store store = Store::mixed_blocks);

/// Value noise in [-1, 1] of wavelength 1, from quintic blending of random values at integers.
double value_noise(const Vec3& p, std::uint64_t seed);

struct Box3 {
  Index low, high;
};
/// 2 x 2 x 2 tiles of `side` cells from `low` on.
std::vector<Box3> eight_tiles(const Index& low, std::int64_t side);

}  // namespace hoodoo::surface::testing
