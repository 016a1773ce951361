#pragma once
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/error.hpp"
#include "engine/tree/node_type.hpp"
#include "engine/tree/voxels.hpp"

namespace hoodoo::tree {

/// Voxels of an OpenVDB file: F = energy clamp((v - low) / (high - low), 0, 1), v the file's value
/// interpolated between voxel centres. Inactive voxels of the file's background value count as
/// unset and have `background`, as has all that lies outside.
///
/// Evaluated in double at the place in the scene. Whoever reads a scene fills in the voxels; from
/// then on `file` is the name of their content and `grid` is empty, so that nothing that is made
/// depends on where they came from. Without voxels the node is 0.
struct VoxelGrid {
  static constexpr std::string_view type = "grid";
  static constexpr std::string_view doc =
      "Voxels of an OpenVDB file: F = energy clamp((v - low) / (high - low), 0, 1), v the value "
      "between voxel centres.";
  static constexpr std::string_view cited = "Museth 2013, VDB; hoodoo";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  enum class Up { z, y };
  enum class Interpolation { linear, quadratic };
  static constexpr std::array<std::string_view, 2> axes{"z", "y"};
  static constexpr std::array<std::string_view, 2> interpolations{"linear", "quadratic"};

  std::string file, grid;
  Point origin;
  Up up = Up::z;
  double metres = 1;
  double low = 0, high = 1;
  double energy = 1;
  std::optional<double> background;
  Interpolation interpolation = Interpolation::linear;
  Voxels voxels;

  static constexpr auto fields() {
    using T = VoxelGrid;
    return std::tuple{
        Text<T>{"file", &T::file, required,
                "OpenVDB file, relative to the scene file; a scene's grids may have 2^26 voxels."},
        Text<T>{"grid", &T::grid, "",
                "Name of the grid in the file; by default its first of "
                "floating-point numbers."},
        Position<T>{"origin", &T::origin, Vec3{0, 0, 0},
                    "Where the file's origin lies; its own transform counts from there."},
        Choice<T, Up>{"up", &T::up, axes, Up::z, "The file's axis that points up."},
        Number<T>{"metres", &T::metres, "m", within(1e-6, 1e6), 1.0, "Length of the file's unit."},
        Number<T>{"low", &T::low, "1", within(-1e30, 1e30), 0.0, "Value that becomes 0."},
        Number<T>{"high", &T::high, "1", within(-1e30, 1e30), 1.0,
                  "Value that becomes `energy`; below `low` for a distance, negative inside."},
        Number<T>{"energy", &T::energy, "1", within(-1000, 1000), 1.0,
                  "Peak of the field; negative carves, or is softer."},
        OptionalNumber<T>{"background", &T::background, "1", within(-1e30, 1e30),
                          "Value where no voxel is set, before `low` and `high`; by default the "
                          "file's own."},
        Choice<T, Interpolation>{"interpolation", &T::interpolation, interpolations,
                                 Interpolation::linear,
                                 "Between voxel centres: linear goes through their values; "
                                 "quadratic, a B-spline, is smooth and rounds them off."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
  Support support(std::span<const Support> children) const;
  Compiled compile_node(const std::vector<Node>& children, const Block& block) const;
  Node prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const;
  friend bool operator==(const VoxelGrid&, const VoxelGrid&) = default;
};

}  // namespace hoodoo::tree
