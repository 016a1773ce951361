#pragma once
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/interval.hpp"
#include "engine/dem/window.hpp"
#include "engine/tree/columns.hpp"
#include "engine/tree/ground.hpp"
#include "engine/tree/points.hpp"

namespace hoodoo::tree {

/// The terrain field F, the resistance rho and what governs them, compiled for one block: pruned
/// to what reaches it, in float32 relative to the block's origin. Immutable; any number of threads.
///
/// Pruned and unpruned values are the same bits, as are those of every instruction set.
class Field {
 public:
  virtual ~Field() = default;

  /// F in [0,1]; solid where F > 1/2.
  virtual void values(const Points& at, std::span<float> out) const = 0;
  /// F at the points of a grid: the bits that `values` gives, found faster. `columns`, if given,
  /// carries what is known of them from one field to the next one above or below. Returns at how
  /// many of the points anything but one body's elevations was asked: at the others no primitive
  /// reaches their row along z.
  virtual std::size_t grid(const Grid& at, std::span<float> out,
                           Columns* columns = nullptr) const = 0;
  /// F and its gradient. `out` has the same bits as from `values`.
  virtual void gradients(const Points& at, std::span<float> out,
                         const Gradients& gradient) const = 0;
  /// Index into Ground::materials of the rock at each point: that of the last operation with a
  /// material of its own that changed F there, else the one whose resistance range holds rho.
  virtual void materials(const Points& at, std::span<int> out) const = 0;
  /// That of every point of the block, where one is known to be.
  virtual std::optional<int> material() const = 0;
  /// rho in [0,1].
  virtual void resistances(const Points& at, std::span<float> out) const = 0;
  /// Contains F at every point of the block's box, rounded outward.
  virtual Interval bounds() const = 0;
  /// The elevations that alone govern the surface in this block (no operation, no second body
  /// reaches it), so that F > 1/2 exactly where z < h(x, y); null otherwise.
  virtual const dem::Window* height_field() const = 0;
  /// What reaches the block, for people: ids of operations and types of nodes, one line each.
  virtual std::vector<std::string> explain() const = 0;
};

/// Compiles `ground` for the block whose points lie in `box`, coordinates relative to `origin`.
/// `windows[i]` holds the elevations of ground.bodies[i] around the box; where it is empty the body
/// is absent. Ground and windows outlive the field. Points of the trees are fixed.
std::unique_ptr<const Field> compile(const Ground& ground, std::span<const dem::Window> windows,
                                     const Vec3& origin, const Box& box);

}  // namespace hoodoo::tree
