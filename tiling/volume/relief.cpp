#include "tiling/volume/relief.hpp"

#include <algorithm>
#include <bit>

namespace hoodoo::volume {

ReliefColumns::ReliefColumns(const Volume& volume, double spacing)
    : spacing_(spacing),
      low_{volume.block_low()[0], volume.block_low()[1]},
      wide_(static_cast<std::size_t>(volume.block_high()[0] - low_[0])) {
  columns_.resize(wide_ * static_cast<std::size_t>(volume.block_high()[1] - low_[1]));
}

const ReliefColumn& ReliefColumns::at(std::int64_t x, std::int64_t y, const dem::Window& window) {
  auto& column = columns_[static_cast<std::size_t>(y - low_[1]) * wide_ +
                          static_cast<std::size_t>(x - low_[0])];
  if (!column) column = std::make_unique_for_overwrite<ReliefColumn>();
  if (column->window != &window) {
    column->window = &window;
    look_up(x, y, *column);
  }
  return *column;
}

void ReliefColumns::look_up(std::int64_t x, std::int64_t y, ReliefColumn& column) const {
  constexpr std::size_t side = ReliefColumn::side;
  std::array<double, side> px, py;
  for (std::size_t i = 0; i < side; ++i) {
    px[i] = static_cast<double>(16 * x + static_cast<int>(i)) * spacing_;
    py[i] = static_cast<double>(16 * y + static_cast<int>(i)) * spacing_;
  }
  std::array<double, side * side> hx, hy, down;
  column.window->grid(px, py, {column.h, hx, hy});
  down.fill(-1.0);
  point_against(hx, hy, down, {column.normal[0], column.normal[1], column.normal[2]});
}

void ReliefCrossings::find(const Index& b, Block& block, const dem::Window& window) {
  if (window_ != &window) finish();
  window_ = &window;
  const ReliefColumn& column = columns_.at(b[0], b[1], window);
  wait(b, block, column);
  cross_upright(b, block, column);
  if (edges_.z.size() >= enough) finish();
}

void ReliefCrossings::cross_upright(const Index& b, Block& block,
                                    const ReliefColumn& column) const {
  Crossing* crossing = block.crossings.data() + block.first[2][0];
  block.for_each_row(2, [&](std::size_t r) {
    const double z = static_cast<double>(16 * b[2] + static_cast<int>(r >> 4)) * spacing_;
    for (unsigned bits = block.crossed[2][r]; bits != 0; bits &= bits - 1, ++crossing) {
      const std::size_t n = side * (r & 15) + static_cast<std::size_t>(std::countr_zero(bits));
      crossing->t = static_cast<float>(std::clamp((column.h[n] - z) / spacing_, 0.0, 1.0));
      crossing->normal = {column.normal[0][n], column.normal[1][n], column.normal[2][n]};
    }
  });
}

/// Lists the level edges. Where an end's elevation contradicts its sign, which is its own block's,
/// the crossing is beside that end.
void ReliefCrossings::wait(const Index& b, Block& block, const ReliefColumn& column) {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    Crossing* crossing = block.crossings.data() + block.first[axis][0];
    block.for_each_row(axis, [&](std::size_t r) {
      for (unsigned bits = block.crossed[axis][r]; bits != 0; bits &= bits - 1, ++crossing) {
        const auto i = static_cast<std::size_t>(std::countr_zero(bits)), j = r & 15;
        const std::size_t low = side * j + i, high = low + (axis == 0 ? 1 : side);
        const double z = static_cast<double>(16 * b[2] + static_cast<int>(r >> 4)) * spacing_;
        const double below = column.h[low] - z, above = column.h[high] - z;
        const bool solid = (block.solid[r] >> i & 1) != 0;
        edges_.crossing.push_back(crossing);
        edges_.x.push_back(static_cast<double>(16 * b[0] + static_cast<int>(i)) * spacing_);
        edges_.y.push_back(static_cast<double>(16 * b[1] + static_cast<int>(j)) * spacing_);
        edges_.z.push_back(z);
        edges_.axis.push_back(static_cast<std::uint8_t>(axis));
        t_.push_back((below > 0) != solid ? nearest_end : 1 - nearest_end);
        if ((below > 0) != solid || (above > 0) == solid) continue;
        open_.push_back(static_cast<std::uint32_t>(t_.size() - 1));
        ends_[0].push_back(below);
        ends_[1].push_back(above);
      }
    });
  }
}

void ReliefCrossings::place(std::size_t edge, double t, std::size_t to) {
  const double along = t * spacing_;
  px_[to] = edges_.x[edge] + (edges_.axis[edge] == 0 ? along : 0);
  py_[to] = edges_.y[edge] + (edges_.axis[edge] == 1 ? along : 0);
}

void ReliefCrossings::find_roots() {
  roots_.start(open_, ends_[0], ends_[1]);
  while (!roots_.edges().empty()) {
    const auto edges = roots_.edges();
    const auto places = roots_.places();
    const std::size_t n = edges.size();
    above_.resize(n + RootLanes::spare);
    for (std::size_t k = 0; k < n; ++k) place(edges[k], places[k], k);
    const auto above = std::span(above_).first(n);
    window_->heights_at(std::span(px_).first(n), std::span(py_).first(n), above);
    for (std::size_t k = 0; k < n; ++k) above[k] -= edges_.z[edges[k]];
    roots_.put(above, t_);
  }
}

void ReliefCrossings::finish() {
  const std::size_t n = t_.size();
  if (n == 0) return;
  for (auto* all : {&px_, &py_, &sx_, &sy_}) all->resize(n);
  for (auto& along : out_) along.resize(n);
  find_roots();
  for (std::size_t k = 0; k < n; ++k) place(k, t_[k], k);
  above_.resize(n);
  window_->at(px_, py_, {above_, sx_, sy_});
  above_.assign(n, -1.0);
  point_against(sx_, sy_, above_, {out_[0], out_[1], out_[2]});
  for (std::size_t k = 0; k < n; ++k) {
    edges_.crossing[k]->t = static_cast<float>(t_[k]);
    edges_.crossing[k]->normal = {out_[0][k], out_[1][k], out_[2][k]};
  }
  edges_.crossing.clear(), edges_.axis.clear(), open_.clear();
  for (auto* all : {&edges_.x, &edges_.y, &edges_.z, &t_, &ends_[0], &ends_[1]}) all->clear();
}

}  // namespace hoodoo::volume
