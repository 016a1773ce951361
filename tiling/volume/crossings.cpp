#include "tiling/volume/crossings.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace hoodoo::volume {
CrossingFinder::CrossingFinder(slice::Land& land, Volume& volume, ReliefColumns& columns)
    : land_(land),
      volume_(volume),
      spacing_(land.slice().spacing()),
      relief_(land.slice().spacing(), columns) {}

void CrossingFinder::find(const Index& b, const BlockValues* known) {
  if (volume_.block(b)->crossings.empty()) return;
  Block& block = volume_.make_block(b);
  const tree::Field& field = land_.field({b[0], b[1], b[2]});
  edges_.clear();
  if (const dem::Window* window = field.height_field()) {
    relief_.find(b, block, *window);
  } else {
    gather_edges(block);
    cross_field(block, field, known);
  }
  set_materials(block, field);
}

/// Those of one part of 4^3 points after those of another: what stands near some of a part's
/// edges mostly stands near all of them, and near few others.
void CrossingFinder::gather_edges(const Block& block) {
  listed_.clear();
  std::array<std::uint16_t, 65> first{};
  const auto part = [](const Edge& e) {
    return static_cast<std::size_t>((e.z >> 2) * 16 + (e.y >> 2) * 4 + (e.x >> 2));
  };
  for (std::uint8_t axis = 0; axis < 3; ++axis) {
    for (std::size_t r = 0; r < 256; ++r) {
      for (unsigned bits = block.crossed[axis][r]; bits != 0; bits &= bits - 1) {
        const int x = std::countr_zero(bits);
        listed_.push_back({static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(r & 15),
                           static_cast<std::uint8_t>(r >> 4), axis, (block.solid[r] >> x & 1) != 0,
                           static_cast<std::uint16_t>(listed_.size())});
        ++first[part(listed_.back()) + 1];
      }
    }
  }
  for (std::size_t i = 1; i < first.size(); ++i) {
    first[i] = static_cast<std::uint16_t>(first[i] + first[i - 1]);
  }
  edges_.resize(listed_.size());
  for (const Edge& edge : listed_) edges_[first[part(edge)]++] = edge;
}

std::span<const std::uint32_t> CrossingFinder::all_edges() {
  chosen_.resize(edges_.size());
  std::iota(chosen_.begin(), chosen_.end(), 0U);
  return chosen_;
}

/// The end whose stored sign the owner's own value contradicts, if any.
std::optional<double> CrossingFinder::disagreeing_end(std::size_t edge) const {
  const bool solid = edges_[edge].solid;
  if ((ends_[0][edge] > 0) != solid) return nearest_end;
  if ((ends_[1][edge] > 0) == solid) return 1 - nearest_end;
  return std::nullopt;
}

/// Begins with the edges whose ends are known.
void CrossingFinder::start_roots() {
  chosen_.clear();
  std::array<std::size_t, 2> kept{};
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (const auto end = disagreeing_end(i)) {
      t_[i] = *end;
      continue;
    }
    chosen_.push_back(static_cast<std::uint32_t>(i));
    for (std::size_t e = 0; e < 2; ++e) ends_[e][kept[e]++] = ends_[e][i];
  }
  roots_.start(chosen_, std::span(ends_[0]).first(kept[0]), std::span(ends_[1]).first(kept[1]));
}

/// All edges step together until the last is done.
void CrossingFinder::cross_field(Block& block, const tree::Field& field, const BlockValues* known) {
  t_.resize(edges_.size());
  find_ends(field, known);
  start_roots();
  while (!roots_.edges().empty()) {
    place_points(roots_.edges(), roots_.places());
    evaluate(field);
    above_.resize(value_.size() + RootLanes::spare);
    for (std::size_t k = 0; k < value_.size(); ++k) {
      above_[k] = static_cast<double>(value_[k]) - iso_value;
    }
    roots_.put(std::span(above_).first(value_.size()), t_);
  }
  finish(block, field);
}

/// The values at both ends of all edges less the iso value, by the block that owns the edges.
void CrossingFinder::find_ends(const tree::Field& field, const BlockValues* known) {
  const std::size_t n = edges_.size();
  for (std::size_t e = 0; e < 2; ++e) {
    ends_[e].resize(n);
    chosen_.clear();
    for (std::size_t i = 0; i < n; ++i) {
      const Edge& edge = edges_[i];
      std::array<std::size_t, 3> at{edge.x, edge.y, edge.z};
      at[edge.axis] += e;
      if (known == nullptr || at[edge.axis] > 15) {
        chosen_.push_back(static_cast<std::uint32_t>(i));
      } else {
        const auto value = (*known)[256 * at[0] + 16 * at[1] + at[2]];
        ends_[e][i] = static_cast<double>(value) - iso_value;
      }
    }
    above_.assign(chosen_.size(), static_cast<double>(e));
    place_points(chosen_, above_);
    evaluate(field);
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
      ends_[e][chosen_[k]] = static_cast<double>(value_[k]) - iso_value;
    }
  }
}

void CrossingFinder::evaluate(const tree::Field& field) {
  value_.resize(x_.size());
  volume_.add_evaluations(x_.size());
  field.values({x_, y_, z_}, value_);
}

/// Points at `at` along the chosen edges, relative to the block's origin.
void CrossingFinder::place_points(std::span<const std::uint32_t> edges,
                                  std::span<const double> at) {
  const std::size_t n = edges.size();
  x_.resize(n), y_.resize(n), z_.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Edge& edge = edges_[edges[k]];
    std::array<double, 3> local{static_cast<double>(edge.x), static_cast<double>(edge.y),
                                static_cast<double>(edge.z)};
    local[edge.axis] += at[k];
    x_[k] = static_cast<float>(local[0] * spacing_);
    y_[k] = static_cast<float>(local[1] * spacing_);
    z_[k] = static_cast<float>(local[2] * spacing_);
  }
}

/// Fills the block's crossings: their normals are against the gradient, or where that is 0 out of
/// the solid end.
void CrossingFinder::finish(Block& block, const tree::Field& field) {
  const std::size_t n = edges_.size();
  place_points(all_edges(), t_);
  value_.resize(n);
  for (auto& along : normal_) along.resize(n);
  volume_.add_evaluations(n);
  field.gradients({x_, y_, z_}, value_, {normal_[0], normal_[1], normal_[2]});
  for (std::size_t a = 0; a < 3; ++a) uphill_[a].assign(normal_[a].begin(), normal_[a].end());
  point_against(uphill_[0], uphill_[1], uphill_[2], {normal_[0], normal_[1], normal_[2]});
  for (std::size_t i = 0; i < n; ++i) {
    Vec3f normal{normal_[0][i], normal_[1][i], normal_[2][i]};
    if (normal == Vec3f{0, 0, 0}) {
      const Edge& edge = edges_[i];
      (edge.axis == 0 ? normal.x : edge.axis == 1 ? normal.y : normal.z) = edge.solid ? 1 : -1;
    }
    Crossing& crossing = block.crossings[edges_[i].crossing];
    crossing.t = static_cast<float>(t_[i]);
    crossing.normal = normal;
  }
}

void CrossingFinder::set_materials(Block& block, const tree::Field& field) {
  if (const auto one = field.material()) {
    for (auto& crossing : block.crossings) crossing.material = static_cast<std::uint16_t>(*one);
    return;
  }
  if (edges_.empty()) gather_edges(block);
  const std::size_t n = edges_.size();
  above_.resize(n);
  for (std::size_t i = 0; i < n; ++i) above_[i] = edges_[i].solid ? 0 : 1;
  place_points(all_edges(), above_);
  material_.resize(n);
  field.materials({x_, y_, z_}, material_);
  for (std::size_t i = 0; i < n; ++i) {
    block.crossings[edges_[i].crossing].material = static_cast<std::uint16_t>(material_[i]);
  }
}

}  // namespace hoodoo::volume
