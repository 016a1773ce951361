#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "engine/dem/window.hpp"
#include "engine/tree/field.hpp"
#include "engine/tree/node.hpp"
#include "engine/tree/region.hpp"
#include "tiling/slice/land.hpp"
#include "tiling/volume/root.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::volume {
namespace {

constexpr double iso = 0.5;
constexpr double nearest_end = 1.0 / 256;  // a crossing that its owner does not bracket

Vec3f to_float(const Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Points of one block that the volume's closed box holds, as [from, to) local indices.
struct Part {
  std::array<int, 3> from, to;
  bool empty() const { return from[0] >= to[0] || from[1] >= to[1] || from[2] >= to[2]; }
};
Part part_of(const Volume& volume, const Index& b) {
  Part part{};
  for (std::size_t a = 0; a < 3; ++a) {
    part.from[a] = static_cast<int>(std::max<std::int64_t>(volume.low()[a] - 16 * b[a], 0));
    part.to[a] = static_cast<int>(std::min<std::int64_t>(volume.high()[a] - 16 * b[a], 15)) + 1;
  }
  return part;
}

/// Fills one volume from a land.
class Sampler {
 public:
  Sampler(slice::Land& land, Volume& volume)
      : land_(land), volume_(volume), spacing_(land.slice().spacing()) {}

  void run() {
    for (std::int64_t y = volume_.block_low()[1]; y < volume_.block_high()[1]; ++y) {
      for (std::int64_t x = volume_.block_low()[0]; x < volume_.block_high()[0]; ++x) {
        sample_column(x, y);
      }
    }
    volume_.mark();
    gather_crossings();
  }

 private:
  Vec3 origin(const Index& b) const {
    const double size = 16 * spacing_;
    return {static_cast<double>(b[0]) * size, static_cast<double>(b[1]) * size,
            static_cast<double>(b[2]) * size};
  }

  /// A meshed cell touches a point of block column (x, y).
  bool column_matters(std::int64_t x, std::int64_t y) const {
    for (std::int64_t j = 16 * y - 1; j < 16 * y + 16; ++j) {
      for (std::int64_t i = 16 * x - 1; i < 16 * x + 16; ++i) {
        if (volume_.meshed(i, j)) return true;
      }
    }
    return false;
  }

  void sample_column(std::int64_t x, std::int64_t y) {
    if (!column_matters(x, y)) return;
    heights_.clear();
    columns_.clear();
    for (std::int64_t z = volume_.block_low()[2]; z < volume_.block_high()[2]; ++z) {
      sample_block({x, y, z});
    }
  }

  void sample_block(const Index& b) {
    const Part part = part_of(volume_, b);
    if (part.empty()) return;
    const tree::Field& field = land_.field({b[0], b[1], b[2]});
    const Interval bounds = field.bounds();
    if (bounds.high <= iso || bounds.low > iso) {
      volume_.set_uniform(b, bounds.low > iso);
      return;
    }
    if (const dem::Window* window = field.height_field()) {
      sample_heights(b, part, *window);
    } else {
      sample_field(b, part, field);
    }
  }

  void sample_heights(const Index& b, const Part& part, const dem::Window& window) {
    const Vec3 at = origin(b);
    if (heights_.empty() || heights_of_ != &window) look_up(at, window);
    Block& block = volume_.make_block(b);
    for (int k = part.from[2]; k < part.to[2]; ++k) {
      const double z = at.z + k * spacing_;
      for (int j = part.from[1]; j < part.to[1]; ++j) {
        unsigned bits = 0;
        for (int i = part.from[0]; i < part.to[0]; ++i) {
          bits |= (heights_[static_cast<std::size_t>(16 * i + j)] > z ? 1U : 0U) << i;
        }
        block.solid[static_cast<std::size_t>(16 * k + j)] = static_cast<std::uint16_t>(bits);
      }
    }
  }

  /// The elevations of the block column at `at`.
  void look_up(const Vec3& at, const dem::Window& window) {
    std::array<double, 16> x, y;
    for (std::size_t i = 0; i < 16; ++i) {
      x[i] = at.x + static_cast<double>(i) * spacing_;
      y[i] = at.y + static_cast<double>(i) * spacing_;
    }
    heights_of_ = &window;
    heights_.resize(256);
    window.heights(x, y, heights_);
  }

  void sample_field(const Index& b, const Part& part, const tree::Field& field) {
    const auto place = [&](std::vector<float>& along, std::size_t axis) {
      along.clear();
      for (int i = part.from[axis]; i < part.to[axis]; ++i) {
        along.push_back(static_cast<float>(i * spacing_));
      }
    };
    place(x_, 0), place(y_, 1), place(z_, 2);
    const tree::Grid grid{x_, y_, z_};
    value_.resize(grid.size());
    field.grid(grid, value_, &columns_);
    Block& block = volume_.make_block(b);
    std::size_t n = 0;
    for (int i = part.from[0]; i < part.to[0]; ++i) {
      for (int j = part.from[1]; j < part.to[1]; ++j) {
        for (int k = part.from[2]; k < part.to[2]; ++k, ++n) {
          auto& row = block.solid[static_cast<std::size_t>(16 * k + j)];
          if (value_[n] > static_cast<float>(iso)) row = static_cast<std::uint16_t>(row | 1U << i);
        }
      }
    }
  }

  /// Edges come block by block: each block's are found in one batch.
  void gather_crossings() {
    std::optional<Index> current;
    volume_.for_each_crossing([&](int axis, const Index& p) {
      const Index b{p[0] >> 4, p[1] >> 4, p[2] >> 4};
      if (current && *current != b) find_crossings(*current);
      current = b;
      edges_.push_back({p, axis});
    });
    if (current) find_crossings(*current);
  }

  void find_crossings(const Index& b) {
    const tree::Field& field = land_.field({b[0], b[1], b[2]});
    if (const dem::Window* window = field.height_field()) {
      for (const auto& edge : edges_) cross_heights(edge, *window);
      set_materials(b, field);
    } else {
      cross_field(b, field);
    }
    edges_.clear();
  }

  struct Edge {
    Index low;
    int axis;
  };

  /// Direct elevation extraction: on a vertical edge the crossing is h itself.
  void cross_heights(const Edge& edge, const dem::Window& window) {
    const auto& p = edge.low;
    const double x = static_cast<double>(p[0]) * spacing_, y = static_cast<double>(p[1]) * spacing_;
    const double z = static_cast<double>(p[2]) * spacing_;
    Vec3 at{x, y, z};
    double t = 0;
    if (edge.axis == 2) {
      t = std::clamp((window.height(x, y) - z) / spacing_, 0.0, 1.0);
    } else {
      const auto above = [&](double u) {
        const double dx = edge.axis == 0 ? u * spacing_ : 0, dy = edge.axis == 1 ? u * spacing_ : 0;
        return window.height(x + dx, y + dy) - z;
      };
      t = cross(edge, above(0), above(1), above);
    }
    at[edge.axis] += t * spacing_;
    const dem::Height h = window.at(at.x, at.y);
    auto& crossing = volume_.crossing(edge.axis, p);
    crossing.t = static_cast<float>(t);
    crossing.normal = to_float(normalized({-h.hx, -h.hy, 1}));
  }

  Index high_end(const Edge& edge) const {
    Index q = edge.low;
    ++q[static_cast<std::size_t>(edge.axis)];
    return q;
  }

  /// The end whose stored sign the owner's own value contradicts, if any.
  std::optional<double> disagreeing_end(const Edge& edge, double low, double high) const {
    if ((low > 0) != volume_.solid(edge.low)) return nearest_end;
    if ((high > 0) != volume_.solid(high_end(edge))) return 1 - nearest_end;
    return std::nullopt;
  }

  template <class Above>
  double cross(const Edge& edge, double low, double high, const Above& above) const {
    if (const auto end = disagreeing_end(edge, low, high)) return *end;
    RootFinder finder(low, high);
    while (!finder.done()) {
      const double t = finder.next();
      finder.put(t, above(t));
    }
    return finder.root();
  }

  void cross_field(const Index& b, const tree::Field& field) {
    const std::size_t n = edges_.size();
    std::vector<double> t(n, 0.0), low(n), high(n);
    evaluate_at(b, field, t);
    for (std::size_t i = 0; i < n; ++i) low[i] = value_[i] - iso;
    std::fill(t.begin(), t.end(), 1.0);
    evaluate_at(b, field, t);
    for (std::size_t i = 0; i < n; ++i) high[i] = value_[i] - iso;
    std::vector<RootFinder> finders(n);
    std::vector<bool> fixed(n, false);
    for (std::size_t i = 0; i < n; ++i) {
      if (const auto end = disagreeing_end(edges_[i], low[i], high[i])) {
        t[i] = *end;
        fixed[i] = true;
      } else {
        finders[i] = RootFinder(low[i], high[i]);
      }
    }
    find_roots(b, field, finders, fixed, t);
    finish_crossings(b, field, t);
  }

  /// All edges of a block step together until the last is done; those done keep their root.
  void find_roots(const Index& b, const tree::Field& field, std::vector<RootFinder>& finders,
                  const std::vector<bool>& fixed, std::vector<double>& t) {
    for (;;) {
      active_.clear();
      for (std::size_t i = 0; i < finders.size(); ++i) {
        if (fixed[i]) continue;
        t[i] = finders[i].done() ? finders[i].root() : finders[i].next();
        if (!finders[i].done()) active_.push_back(i);
      }
      if (active_.empty()) return;
      place_points(b, t, active_);
      value_.resize(x_.size());
      field.values({x_, y_, z_}, value_);
      for (std::size_t k = 0; k < active_.size(); ++k) {
        finders[active_[k]].put(t[active_[k]], value_[k] - iso);
      }
    }
  }

  void evaluate_at(const Index& b, const tree::Field& field, const std::vector<double>& t) {
    active_.resize(edges_.size());
    for (std::size_t i = 0; i < edges_.size(); ++i) active_[i] = i;
    place_points(b, t, active_);
    value_.resize(x_.size());
    field.values({x_, y_, z_}, value_);
  }

  /// Points at `t` along the chosen edges, relative to the block's origin.
  void place_points(const Index& b, const std::vector<double>& t,
                    const std::vector<std::size_t>& chosen) {
    x_.resize(chosen.size()), y_.resize(chosen.size()), z_.resize(chosen.size());
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      const Edge& edge = edges_[chosen[k]];
      Vec3 local{static_cast<double>(edge.low[0] - 16 * b[0]),
                 static_cast<double>(edge.low[1] - 16 * b[1]),
                 static_cast<double>(edge.low[2] - 16 * b[2])};
      local[edge.axis] += t[chosen[k]];
      x_[k] = static_cast<float>(local.x * spacing_);
      y_[k] = static_cast<float>(local.y * spacing_);
      z_[k] = static_cast<float>(local.z * spacing_);
    }
  }

  void finish_crossings(const Index& b, const tree::Field& field, const std::vector<double>& t) {
    const std::size_t n = edges_.size();
    evaluate_at(b, field, t);
    std::vector<float> gx(n), gy(n), gz(n);
    field.gradients({x_, y_, z_}, value_, {gx, gy, gz});
    for (std::size_t i = 0; i < n; ++i) {
      const Edge& edge = edges_[i];
      auto& crossing = volume_.crossing(edge.axis, edge.low);
      Vec3 outward;
      outward[edge.axis] = volume_.solid(edge.low) ? 1 : -1;
      crossing.t = static_cast<float>(t[i]);
      crossing.normal = to_float(normalized({-gx[i], -gy[i], -gz[i]}, outward));
    }
    set_materials(b, field);
  }

  void set_materials(const Index& b, const tree::Field& field) {
    const std::size_t n = edges_.size();
    std::vector<double> solid_end(n);
    active_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      solid_end[i] = volume_.solid(edges_[i].low) ? 0 : 1;
      active_[i] = i;
    }
    place_points(b, solid_end, active_);
    material_.resize(n);
    field.materials({x_, y_, z_}, material_);
    for (std::size_t i = 0; i < n; ++i) {
      volume_.crossing(edges_[i].axis, edges_[i].low).material =
          static_cast<std::uint16_t>(material_[i]);
    }
  }

  slice::Land& land_;
  Volume& volume_;
  double spacing_;
  std::vector<double> heights_;  // of the block column at hand at 16 i + j, once asked for
  const dem::Window* heights_of_ = nullptr;
  tree::Columns columns_;    // of the same block column
  std::vector<Edge> edges_;  // of the block at hand
  std::vector<std::size_t> active_;
  std::vector<float> x_, y_, z_, value_;
  std::vector<int> material_;
};

/// Whole blocks of z, in cells, that hold every surface over the tile.
std::array<std::int64_t, 2> z_cells(const slice::Land& land) {
  const auto& slice = land.slice();
  Box area = slice.lattice.area(slice.key).grown(slice.spacing());
  Interval range = land.heights(area);
  // Step by step, since one without a bound must not hide where another ends.
  for (const tree::Step& step : slice.ground.steps) {
    Box reach = tree::support(step.tree).influence;
    if (step.region) reach = intersection(reach, step.region->influence());
    if (reach.empty()) continue;
    if (std::isfinite(reach.min.z)) range.low = std::min(range.low, reach.min.z);
    if (std::isfinite(reach.max.z)) range.high = std::max(range.high, reach.max.z);
  }
  if (!(range.low <= range.high)) return {0, 16};
  const double block = 16 * slice.spacing();
  const auto low = static_cast<std::int64_t>(std::floor((range.low - slice.spacing()) / block));
  const auto high = static_cast<std::int64_t>(std::ceil((range.high + slice.spacing()) / block));
  return {16 * low, 16 * std::max(high, low + 1)};
}

}  // namespace

Volume sample(slice::Land& land) {
  const auto& slice = land.slice();
  const std::int64_t cells = slice.lattice.tile_cells;
  const auto z = z_cells(land);
  Volume volume({slice.key.x * cells, slice.key.y * cells, z[0]},
                {(slice.key.x + 1) * cells, (slice.key.y + 1) * cells, z[1]});
  bool any = false;
  for (std::int64_t j = volume.low()[1] - 1; j <= volume.high()[1]; ++j) {
    for (std::int64_t i = volume.low()[0] - 1; i <= volume.high()[0]; ++i) {
      volume.set_in_world(i, j, land.in_world(i, j));
      any = any || volume.meshed(i, j);
    }
  }
  if (any) Sampler(land, volume).run();
  return volume;
}

}  // namespace hoodoo::volume
