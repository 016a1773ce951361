#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/interval.hpp"
#include "engine/base/random.hpp"
#include "engine/base/sample_cells.hpp"
#include "engine/base/sample_cover.hpp"

/// How sampling.cpp fills its kinds of ground.
namespace hoodoo::sampling {

/// A box in which there may be room, by its place on the lattice of its level.
struct Part {
  Cell at;
  double radius_least;                                // no allowed point of it has a smaller one
  double low = -Box::infinity, high = Box::infinity;  // of a shell: room is between these alone
};

enum class Fate : std::uint8_t { open, in, out };
enum State : std::uint32_t { thrown = 1, ready = 2, settled = 4, filled = 8 };

/// Cells are as wide as samples can matter to each other. First, darts: many in each cell, accepted
/// in the order of their hashes. Each is decided when it is asked for, by deciding those of higher
/// hashes that it conflicts with: chains of rising hashes are short, though nothing bounds them.
/// Then what room they leave in each cell is filled, in the order of the cells' colours: cells of
/// one colour do not touch, so a cell waits for its neighbours of lower colours alone, which lie
/// at most three cells away in the plane and seven in space.
///
/// `Ground` is one of sampling.cpp's kinds: `of` is what was asked for, `radius` its radius at a
/// point, `flat` says that cells lie in the plane, `shell` that they are columns through a shell.
template <class Ground>
class Sampler {
 public:
  static constexpr bool flat = Ground::flat, shell = Ground::shell;
  /// In a shell filling costs less than darts do: of what is left of a column none falls beside.
  static constexpr int darts_per_cell = shell ? 2 : 12;
  static constexpr std::size_t first_level = shell ? 1 : 3;  // of parts that are filled

  explicit Sampler(const Ground& ground)
      : ground_(ground),
        side_(2 * ground.of.radius_most),
        varies_(ground.of.radius && ground.of.radius_least != ground.of.radius_most),
        darts_(ground.of.radius_least, ground.of.radius_most),
        samples_(ground.of.radius_least, ground.of.radius_most) {
    for (double side = side_;; side /= 2) {
      sides_.push_back(side);
      if (side <= ground_.of.radius_least / 128) break;
    }
  }

  /// Completes the cells from `low` to `high`, by halving what is asked about.
  void run(const Cell& low, const Cell& high) {
    if constexpr (!shell) {
      Cube all{cube(low, side_).low, cube(high, side_).high};
      if (!may_hold(all)) return;
    }
    const Cell size{high.x - low.x, high.y - low.y, high.z - low.z};
    const std::int32_t most = std::max({size.x, size.y, size.z});
    if (most == 0) return fill(low);
    const auto axis = size.z == most ? &Cell::z : size.y == most ? &Cell::y : &Cell::x;
    Cell middle = high, next = low;
    middle.*axis = low.*axis + most / 2;
    next.*axis = middle.*axis + 1;
    run(low, middle);
    run(next, high);
  }
  const std::vector<Sample>& samples() const { return samples_.all(); }

 private:
  Cube cube(const Cell& c, double side) const {
    constexpr double all = shell ? Box::infinity : 0;
    return {{c.x * side, c.y * side, flat ? -all : c.z * side},
            {(c.x + 1) * side, (c.y + 1) * side, flat ? all : (c.z + 1) * side}};
  }
  Cube cube(const Part& part, double side) const {
    auto box = cube(part.at, side);
    if constexpr (shell) box.low.z = part.low, box.high.z = part.high;
    return box;
  }
  /// Whether a point of the box may have a sample. Of a shell's box only what lies between the
  /// bounds of its top and bottom is left.
  bool may_hold(Cube& box) const {
    if constexpr (shell) {
      const Interval tops = ground_.of.tops({box.low, box.high});
      box.low.z = std::max(box.low.z, tops.low - ground_.of.thickness);
      box.high.z = std::min(box.high.z, tops.high);
      return box.low.z <= box.high.z;
    } else {
      return !ground_.of.may_hold || ground_.of.may_hold({box.low, box.high});
    }
  }
  double radius_at(const Vec3& p) const {
    if (shell && std::isnan(p.z)) return 0;
    if (!ground_.of.radius) return ground_.of.radius_least;
    const double radius = ground_.radius(p);
    return radius > 0 ? std::clamp(radius, ground_.of.radius_least, ground_.of.radius_most) : 0;
  }

  template <class Visit>
  void around(const Cell& c, Visit visit) {
    for_each_cell<flat>({c.x - 1, c.y - 1, c.z - 1}, {c.x + 1, c.y + 1, c.z + 1}, visit);
  }
  /// Whether the cell reaches this state only now.
  bool enters(const Cell& c, State state) {
    const auto was = state_.get(c);
    if (was != none && (was & state) != 0) return false;
    state_.set(c, (was == none ? 0 : was) | state);
    return true;
  }

  /// In a shell without a z where its column has no ground in the box, or no room for a sample of
  /// that radius among those near.
  Vec3 dart(const Cube& box, std::uint64_t id, double room_for = 0) const {
    constexpr double per_step = 1.0 / (1 << 21);
    const double side = box.high.x - box.low.x;
    const std::uint64_t bits = mix(id + 0x9e3779b97f4a7c15U);
    const auto along = [&](double low, int shift) {
      return low + side * (static_cast<double>(bits >> shift & 0x1fffff) * per_step);
    };
    Vec3 p{along(box.low.x, 0), along(box.low.y, 21), flat ? 0 : along(box.low.z, 42)};
    if constexpr (shell) {
      const double top = ground_.of.top(p.x, p.y);
      const double low = std::max(top - ground_.of.thickness, box.low.z);
      const double high = std::min(top, box.high.z);
      const double share = static_cast<double>(bits >> 42 & 0x1fffff) * per_step;
      if (!(low <= high)) {
        p.z = std::numeric_limits<double>::quiet_NaN();
      } else if (room_for > 0) {
        p.z = near_.height_left(p, low, high, room_for, share);
      } else {
        p.z = low + (high - low) * share;
      }
    }
    return p;
  }
  std::uint64_t seed_of(std::size_t level, int phase) const {
    return random_bits(ground_.of.seed, flat ? 2 : 3, level, phase);
  }

  void throw_darts(const Cell& cell) {
    if (!enters(cell, thrown)) return;
    throw_darts(cell, 0);
  }
  /// Darts for radii of one size, in boxes of that size; for smaller radii in its halves.
  void throw_darts(const Cell& at, std::size_t size) {
    Cube box = cube(at, sides_[size]);
    // In a shell each dart finds out by itself: bounds cost more.
    if ((!shell || varies_) && !may_hold(box)) return;
    const std::uint64_t seed = seed_of(size, 0);
    const Vec3 middle = box.middle();
    double least = varies_ ? radius_at(middle) : ground_.of.radius_least;
    bool any = least > 0;
    least -= varies_ ? ground_.of.slope * std::sqrt(squared_farthest(box, middle)) : 0;
    for (int n = 0; n < darts_per_cell; ++n) {
      const std::uint64_t id = random_bits(seed, at.x, at.y, at.z, n);
      const Vec3 p = dart(box, id);
      const double radius = radius_at(p);
      any = any || radius > 0;
      if (radius <= 0 || darts_.size_of(radius) != size) continue;
      darts_.add({p, radius, id});
      fates_.push_back(Fate::open);
    }
    if (size + 1 == darts_.sizes() || !any) return;
    if (least > 0 && darts_.size_of(least) <= size) return;
    for_each_cell<flat>({2 * at.x, 2 * at.y, 2 * at.z}, {2 * at.x + 1, 2 * at.y + 1, 2 * at.z + 1},
                        [&](const Cell& half) { throw_darts(half, size + 1); });
  }

  Fate decide(std::uint32_t number) {
    if (fates_[number] != Fate::open) return fates_[number];
    const Sample dart = darts_.all()[number];
    const auto cell = cell_at<flat>(dart.center, 1 / side_);
    if (enters(cell, ready)) around(cell, [&](const Cell& c) { throw_darts(c); });
    const bool out = samples_.any_near(dart.center, dart.radius, [&](std::uint32_t s) {
      return conflict(samples_.all()[s], dart.center, dart.radius);
    }) || darts_.any_near(dart.center, dart.radius, [&](std::uint32_t other) {
      const Sample& o = darts_.all()[other];
      return fates_[other] != Fate::out && o.id > dart.id &&
             conflict(o, dart.center, dart.radius) && decide(other) == Fate::in;
    });
    if (!out) samples_.add(dart);
    return fates_[number] = out ? Fate::out : Fate::in;
  }

  void settle(const Cell& cell) {
    if (!enters(cell, settled)) return;
    throw_darts(cell);
    // Those in its middle and around; what else is met is decided early, not otherwise.
    const Cube box = cube(cell, side_);
    darts_.any_near(box.middle(), side_ / 2, [&](std::uint32_t n) {
      const auto& p = darts_.all()[n].center;
      if (squared_nearest(box, p) <= 0) decide(n);
      return false;
    });
  }

  void fill(const Cell& cell) {
    if (!enters(cell, filled)) return;
    around(cell, [&](const Cell& c) { settle(c); });
    const Cube box = cube(cell, side_);
    const Part whole{cell, ground_.of.radius_least};
    std::vector<Part> parts;
    parts.swap(spare_);
    parts.clear();
    if constexpr (!shell) {  // most cells of a volume have no room, and need no others
      gather(box);
      open_parts(whole, 0, 0, parts);
      if (parts.empty()) return;
    }
    const auto mine = color(cell);
    around(cell, [&](const Cell& c) {
      if (color(c) < mine) fill(c);
    });
    gather(box);
    // Of a shell's parts what is kept must not depend on which cells were filled before.
    if constexpr (shell) open_parts(whole, 0, 0, parts);
    for (std::size_t level = first_level; level < sides_.size() && !parts.empty(); ++level) {
      fill_parts(parts, level);
    }
    parts.swap(spare_);
  }
  static unsigned color(const Cell& c) {
    const auto bit = [](std::int32_t v) { return static_cast<unsigned>(v) & 1U; };
    return bit(c.x) | bit(c.y) << 1 | bit(c.z) << 2;
  }

  /// Near the ground of a column: nothing else that is known of it but its place matters.
  Vec3 corner_of(const Cube& column) const {
    const Vec3 m = column.middle();
    double top = 0;
    if constexpr (shell) top = ground_.of.top(m.x, m.y);
    return {column.low.x, column.low.y, std::isfinite(top) ? top : 0};
  }
  /// Samples that may leave no room somewhere in the box.
  void gather(const Cube& box) {
    near_.clear(shell ? corner_of(box) : box.low);
    const double most = ground_.of.radius_most, half = 0.5 * (box.high.x - box.low.x);
    samples_.any_near(box.middle(), most + half, [&](std::uint32_t n) {
      const auto& s = samples_.all()[n];
      if (squared_nearest(box, s.center) < squared(s.radius + most)) near_.add(s);
      return false;
    });
  }
  /// Whether there may be room in the part; its box. Of a shell it is the half with that number of
  /// the part halved last, and keeps only the heights between which there may be.
  bool is_open(Part& part, Cube& box, std::size_t half) const {
    if constexpr (shell) {
      const auto bound = [this](Cube& narrowed) { return may_hold(narrowed); };
      if (!near_.narrow(box, half, bound)) return false;
      part.low = box.low.z, part.high = box.high.z;
      return true;
    } else {
      return !near_.cover(box, part.radius_least) && may_hold(box);
    }
  }

  /// Parts of the first level that may have room.
  void open_parts(Part part, std::size_t level, std::size_t half, std::vector<Part>& open) {
    static_assert(!shell || first_level == 1, "near_ knows the halves of one part");
    Cube box = cube(part, sides_[level]);
    if (shell && level == 0) {  // as wide as a cell: it has room where it has ground
      if (varies_ && !may_hold(box)) return;
    } else if (!is_open(part, box, half)) {
      return;
    }
    if (varies_) {
      raise(part, box, box.middle(), radius_at(box.middle()));
      if (near_.cover(box, part.radius_least)) return;
    }
    if (level == first_level) {
      open.push_back(part);
      return;
    }
    for_each_half(part, level, [&](const Part& next, std::size_t number) {
      open_parts(next, level + 1, number, open);
    });
  }
  void raise(Part& part, const Cube& box, const Vec3& p, double radius) const {
    if (radius <= 0) return;
    const double least = radius - ground_.of.slope * std::sqrt(squared_farthest(box, p));
    part.radius_least = std::max(part.radius_least, least);
  }
  /// The halves of a part of that level, with their numbers.
  template <class Visit>
  void for_each_half(const Part& part, std::size_t level, Visit visit) {
    if constexpr (shell) near_.halve(cube(part, sides_[level]), part.radius_least);
    const Cell& c = part.at;
    std::size_t number = 0;
    for_each_cell<flat>({2 * c.x, 2 * c.y, 2 * c.z}, {2 * c.x + 1, 2 * c.y + 1, 2 * c.z + 1},
                        [&](const Cell& half) {
                          visit(Part{half, part.radius_least, part.low, part.high}, number++);
                        });
  }

  /// A dart into each part of the first level, then into the halves of those left; those accepted
  /// go among those near. Leaves the parts that may still have room.
  void fill_parts(std::vector<Part>& parts, std::size_t level) {
    const std::uint64_t seed = seed_of(level, 1);
    new_.clear(), open_.clear();
    for (const auto& part : parts) {
      if (level == first_level) {
        throw_into(part, level, 0, seed);
      } else {
        for_each_half(part, level - 1, [&](const Part& half, std::size_t number) {
          throw_into(half, level, number, seed);
        });
      }
    }
    std::ranges::sort(new_, std::ranges::greater(), &Sample::id);
    const auto before = near_.size();
    for (const auto& s : new_) {
      if (near_.rule_out(s.center, s.radius)) continue;
      samples_.add(s);
      near_.add(s);
    }
    parts.clear();
    for (const auto& part : open_) {
      const Cube box = cube(part, sides_[level]);
      if (!near_.cover(box, part.radius_least, varies_ ? 0 : before)) parts.push_back(part);
    }
  }
  void throw_into(Part part, std::size_t level, std::size_t half, std::uint64_t seed) {
    const double side = sides_[level];
    Cube box = cube(part, side);
    // Those of a shell's first level are open: nothing was added since.
    if ((!shell || level > first_level) && !is_open(part, box, half)) return;
    const std::uint64_t id = random_bits(seed, part.at.x, part.at.y, part.at.z);
    const Vec3 p = dart(box, id, part.radius_least);
    const double radius = radius_at(p);
    if (radius <= 0 && forbidden(box, side)) return;
    if (varies_) {
      const Vec3 known = shell && radius <= 0 ? box.middle() : p;
      raise(part, box, known, radius_at(known));
    }
    // In a shell there is room for it, nearly always.
    if (radius > 0 && (shell || !near_.rule_out(p, radius))) new_.push_back({p, radius, id});
    open_.push_back(part);
  }
  /// Whether no sample may lie in the box, one of whose points was not allowed: small ones are
  /// known by their corners.
  bool forbidden(const Cube& box, double side) const {
    if (side > ground_.of.radius_least / 4) return false;
    for (unsigned corner = 0; corner < (flat && !shell ? 4 : 8); ++corner) {
      const Vec3 p{(corner & 1) != 0 ? box.high.x : box.low.x,
                   (corner & 2) != 0 ? box.high.y : box.low.y,
                   (corner & 4) != 0 ? box.high.z : box.low.z};
      if (radius_at(p) > 0) return false;
    }
    return true;
  }

  Ground ground_;
  double side_;  // of a cell: as far as samples matter to each other
  bool varies_;
  std::vector<double> sides_;  // of the parts of each level
  Samples<flat> darts_, samples_;
  std::vector<Fate> fates_;  // of darts
  Cells<flat> state_;
  Nearby near_;
  std::vector<Sample> new_;  // of the level that is filled
  std::vector<Part> open_;   // of it
  std::vector<Part> spare_;  // its memory serves the next cell
};

}  // namespace hoodoo::sampling
