#include "tiling/volume/crossings.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace hoodoo::volume {
namespace {

constexpr double iso = 0.5;
constexpr double nearest_end = 1.0 / 256;  // a crossing that its owner does not bracket
constexpr std::size_t spare = 8;           // what RootLanes::put may read beyond its values

}  // namespace

CrossingFinder::CrossingFinder(slice::Land& land, Volume& volume)
    : land_(land), volume_(volume), spacing_(land.slice().spacing()) {}

void CrossingFinder::find(const Index& b, const BlockValues* known) {
  gather_edges(b);
  if (edges_.empty()) return;
  const tree::Field& field = land_.field({b[0], b[1], b[2]});
  t_.resize(edges_.size());
  if (const dem::Window* window = field.height_field()) {
    cross_heights(*window);
  } else {
    cross_field(b, field, known);
  }
  set_materials(b, field);
}

/// In the order of the block's crossings: by axis, then by row.
void CrossingFinder::gather_edges(const Index& b) {
  edges_.clear();
  const Block& block = *volume_.block(b);
  if (block.crossings.empty()) return;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& crossed = block.crossed[static_cast<std::size_t>(axis)];
    for (int r = 0; r < 256; ++r) {
      for (unsigned bits = crossed[static_cast<std::size_t>(r)]; bits != 0; bits &= bits - 1) {
        edges_.push_back(
            {{16 * b[0] + std::countr_zero(bits), 16 * b[1] + (r & 15), 16 * b[2] + (r >> 4)},
             axis});
      }
    }
  }
}

std::span<const std::uint32_t> CrossingFinder::all_edges(std::size_t count) {
  chosen_.resize(count);
  std::iota(chosen_.begin(), chosen_.end(), 0U);
  return chosen_;
}

/// The end whose stored sign the owner's own value contradicts, if any.
std::optional<double> CrossingFinder::disagreeing_end(std::size_t edge) const {
  const Edge& e = edges_[edge];
  if ((ends_[0][edge] > 0) != volume_.solid(e.low)) return nearest_end;
  Index high = e.low;
  ++high[static_cast<std::size_t>(e.axis)];
  if ((ends_[1][edge] > 0) != volume_.solid(high)) return 1 - nearest_end;
  return std::nullopt;
}

/// Begins with the first `count` edges whose ends are known.
void CrossingFinder::start_roots(std::size_t count) {
  chosen_.clear();
  std::array<std::size_t, 2> kept{};
  for (std::size_t i = 0; i < count; ++i) {
    if (const auto end = disagreeing_end(i)) {
      t_[i] = *end;
      continue;
    }
    chosen_.push_back(static_cast<std::uint32_t>(i));
    for (std::size_t e = 0; e < 2; ++e) ends_[e][kept[e]++] = ends_[e][i];
  }
  roots_.start(chosen_, std::span(ends_[0]).first(kept[0]), std::span(ends_[1]).first(kept[1]));
}

/// All edges step together until the last is done. evaluate(edges, places) leaves the values less
/// the iso value in `above_`.
template <class Evaluate>
void CrossingFinder::find_roots(Evaluate evaluate) {
  while (!roots_.edges().empty()) {
    const auto places = roots_.places();
    above_.resize(places.size() + spare);
    evaluate(roots_.edges(), places);
    roots_.put(std::span(above_).first(places.size()), t_);
  }
}

/// Direct elevation extraction: on a vertical edge the crossing is h itself.
void CrossingFinder::cross_heights(const dem::Window& window) {
  const std::size_t n = edges_.size();
  const auto level = static_cast<std::size_t>(
      std::find_if(edges_.begin(), edges_.end(), [](const Edge& e) { return e.axis == 2; }) -
      edges_.begin());
  for (auto* all : {&px_, &py_, &h_, &hx_, &hy_}) all->resize(n);
  if (level > 0) cross_along_ground(window, level);
  for (std::size_t i = 0; i < n; ++i) {
    const Edge& e = edges_[i];
    px_[i] = static_cast<double>(e.low[0]) * spacing_;
    py_[i] = static_cast<double>(e.low[1]) * spacing_;
    if (e.axis == 0) px_[i] += t_[i] * spacing_;
    if (e.axis == 1) py_[i] += t_[i] * spacing_;
  }
  window.at(px_, py_, {h_, hx_, hy_});
  for (std::size_t i = level; i < n; ++i) {
    const double z = static_cast<double>(edges_[i].low[2]) * spacing_;
    t_[i] = std::clamp((h_[i] - z) / spacing_, 0.0, 1.0);
  }
  h_.assign(n, -1.0);
  put_normals({hx_, hy_, h_});
}

/// The first `count` edges, which are level.
void CrossingFinder::cross_along_ground(const dem::Window& window, std::size_t count) {
  const auto heights = [&](std::span<const std::uint32_t> edges, std::span<const double> places,
                           std::span<double> above) {
    const std::size_t n = edges.size();
    for (std::size_t k = 0; k < n; ++k) {
      const Edge& e = edges_[edges[k]];
      const double along = places[k] * spacing_;
      px_[k] = static_cast<double>(e.low[0]) * spacing_ + (e.axis == 0 ? along : 0);
      py_[k] = static_cast<double>(e.low[1]) * spacing_ + (e.axis == 1 ? along : 0);
    }
    window.heights_at(std::span(px_).first(n), std::span(py_).first(n), above.first(n));
    for (std::size_t k = 0; k < n; ++k) {
      above[k] -= static_cast<double>(edges_[edges[k]].low[2]) * spacing_;
    }
  };
  for (std::size_t e = 0; e < 2; ++e) {
    ends_[e].resize(count);
    h_.assign(count, static_cast<double>(e));
    heights(all_edges(count), std::span(h_).first(count), ends_[e]);
  }
  start_roots(count);
  find_roots([&](auto edges, auto places) { heights(edges, places, above_); });
  h_.resize(edges_.size());
}

void CrossingFinder::cross_field(const Index& b, const tree::Field& field,
                                 const BlockValues* known) {
  find_ends(b, field, known);
  start_roots(edges_.size());
  find_roots([&](auto edges, auto places) {
    place_points(b, edges, places);
    evaluate(field);
    for (std::size_t k = 0; k < value_.size(); ++k) {
      above_[k] = static_cast<double>(value_[k]) - iso;
    }
  });
  finish(b, field);
}

/// The values at both ends of all edges less the iso value, by the block that owns the edges.
void CrossingFinder::find_ends(const Index& b, const tree::Field& field, const BlockValues* known) {
  const std::size_t n = edges_.size();
  for (std::size_t e = 0; e < 2; ++e) {
    ends_[e].resize(n);
    chosen_.clear();
    for (std::size_t i = 0; i < n; ++i) {
      std::array<std::int64_t, 3> at{};
      for (std::size_t a = 0; a < 3; ++a) at[a] = edges_[i].low[a] - 16 * b[a];
      at[static_cast<std::size_t>(edges_[i].axis)] += static_cast<std::int64_t>(e);
      if (known == nullptr || at[0] > 15 || at[1] > 15 || at[2] > 15) {
        chosen_.push_back(static_cast<std::uint32_t>(i));
      } else {
        const auto place = static_cast<std::size_t>(256 * at[0] + 16 * at[1] + at[2]);
        ends_[e][i] = static_cast<double>((*known)[place]) - iso;
      }
    }
    above_.assign(chosen_.size(), static_cast<double>(e));
    place_points(b, chosen_, above_);
    evaluate(field);
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
      ends_[e][chosen_[k]] = static_cast<double>(value_[k]) - iso;
    }
  }
}

void CrossingFinder::evaluate(const tree::Field& field) {
  value_.resize(x_.size());
  volume_.add_evaluations(x_.size());
  field.values({x_, y_, z_}, value_);
}

/// Points at `at` along the chosen edges, relative to the block's origin.
void CrossingFinder::place_points(const Index& b, std::span<const std::uint32_t> edges,
                                  std::span<const double> at) {
  const std::size_t n = edges.size();
  x_.resize(n), y_.resize(n), z_.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Edge& edge = edges_[edges[k]];
    Vec3 local{static_cast<double>(edge.low[0] - 16 * b[0]),
               static_cast<double>(edge.low[1] - 16 * b[1]),
               static_cast<double>(edge.low[2] - 16 * b[2])};
    local[edge.axis] += at[k];
    x_[k] = static_cast<float>(local.x * spacing_);
    y_[k] = static_cast<float>(local.y * spacing_);
    z_[k] = static_cast<float>(local.z * spacing_);
  }
}

void CrossingFinder::finish(const Index& b, const tree::Field& field) {
  const std::size_t n = edges_.size();
  place_points(b, all_edges(n), t_);
  value_.resize(n);
  for (auto& along : normal_) along.resize(n);
  volume_.add_evaluations(n);
  field.gradients({x_, y_, z_}, value_, {normal_[0], normal_[1], normal_[2]});
  const std::array<std::vector<double>*, 3> uphill{&hx_, &hy_, &h_};
  for (std::size_t a = 0; a < 3; ++a) uphill[a]->assign(normal_[a].begin(), normal_[a].end());
  put_normals({hx_, hy_, h_});
}

/// Fills the block's crossings: against `uphill`, or where that is 0 out of the solid end.
void CrossingFinder::put_normals(const std::array<std::span<const double>, 3>& uphill) {
  const std::size_t n = edges_.size();
  for (auto& along : normal_) along.resize(n);
  point_against(uphill[0], uphill[1], uphill[2], {normal_[0], normal_[1], normal_[2]});
  for (std::size_t i = 0; i < n; ++i) {
    const Edge& edge = edges_[i];
    Vec3f normal{normal_[0][i], normal_[1][i], normal_[2][i]};
    if (normal == Vec3f{0, 0, 0}) {
      const float out = volume_.solid(edge.low) ? 1 : -1;
      (edge.axis == 0 ? normal.x : edge.axis == 1 ? normal.y : normal.z) = out;
    }
    auto& crossing = volume_.crossing(edge.axis, edge.low);
    crossing.t = static_cast<float>(t_[i]);
    crossing.normal = normal;
  }
}

void CrossingFinder::set_materials(const Index& b, const tree::Field& field) {
  const std::size_t n = edges_.size();
  above_.resize(n);
  for (std::size_t i = 0; i < n; ++i) above_[i] = volume_.solid(edges_[i].low) ? 0 : 1;
  place_points(b, all_edges(n), above_);
  material_.resize(n);
  field.materials({x_, y_, z_}, material_);
  for (std::size_t i = 0; i < n; ++i) {
    volume_.crossing(edges_[i].axis, edges_[i].low).material =
        static_cast<std::uint16_t>(material_[i]);
  }
}

}  // namespace hoodoo::volume
