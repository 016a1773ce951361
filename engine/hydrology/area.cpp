#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>

#include "engine/base/math.hpp"
#include "engine/hydrology/accumulation.hpp"

namespace hoodoo::hydrology {
namespace {

constexpr double freeman_exponent = 1.1;

/// x^(1/10) of a positive number to 1e-9, by Halley's method for y^5 = x from a guess within 6 %.
double tenth_root(double x) {
  constexpr std::uint64_t guess = 0x3325'9999'9999'999aULL;  // 4/5 of the bits of 1, less a trifle
  double y = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) / 5 + guess);
  for (int step = 0; step < 2; ++step) {
    const double fifth = (y * y) * (y * y) * y;
    y = y * (2 * fifth + 3 * x) / (3 * fifth + 2 * x);
  }
  return std::sqrt(y);
}

template <class Visit>
void for_each(unsigned bits, Visit visit) {
  for (; bits != 0; bits &= bits - 1) visit(static_cast<unsigned>(std::countr_zero(bits)));
}

bool differ(const std::vector<double>& sizes) {
  return std::ranges::adjacent_find(sizes, std::ranges::not_equal_to()) != sizes.end();
}

}  // namespace

Accumulation::Accumulation(const Grid& grid, Rows rows, double exponent)
    : grid_(grid), rows_(rows), exponent_(exponent), neighbours_(grid) {
  const bool rows_differ = differ(grid.dx) || differ(grid.dy);
  for (std::int32_t j = 0; j < (rows_differ ? grid.height : 1); ++j)
    distances_.emplace_back(grid, j);
}

std::size_t Accumulation::settle(const Cells& cells) {
  cells_ = cells;
  settled_ = 0;
  find_donors();
  const std::size_t end = grid_.index(0, rows_.to);
  for (std::size_t cell = grid_.index(0, rows_.from); cell < end; ++cell) {
    if (missing_[cell] == 0 && cells_.per_weight[cell] == 0 && grid_.valid(cell)) {
      settle_from(cell);
    }
  }
  return settled_;
}

/// Cells beyond the rows count as missing something, so that nothing settles them.
void Accumulation::find_donors() {
  donors_.assign(grid_.size(), 0);
  missing_.assign(grid_.size(), 0);
  for (std::size_t cell = 0; cell < grid_.size(); ++cell) {
    // Those of the outer rows may lie beyond the grid: they do not matter here.
    const unsigned missing = cells_.per_weight[cell] == 0 ? 1 : 0;
    for_each(cells_.receivers[cell] & neighbours_.inside(cell), [&](unsigned k) {
      const auto to = neighbours_.at(cell, k);
      donors_[to] = static_cast<std::uint8_t>(donors_[to] | 1U << opposite(k));
      missing_[to] = static_cast<std::uint8_t>(missing_[to] | missing << opposite(k));
    });
  }
  const std::size_t begin = grid_.index(0, rows_.from), end = grid_.index(0, rows_.to);
  std::fill(missing_.begin(), missing_.begin() + static_cast<std::ptrdiff_t>(begin), 0xff);
  std::fill(missing_.begin() + static_cast<std::ptrdiff_t>(end), missing_.end(), 0xff);
}

void Accumulation::settle_from(std::size_t first) {
  const std::size_t begin = grid_.index(0, rows_.from), end = grid_.index(0, rows_.to);
  ready_.push_back(static_cast<std::uint32_t>(first));
  while (!ready_.empty()) {
    const std::size_t cell = ready_.back();
    ready_.pop_back();
    settle_cell(cell);
    for_each(cells_.receivers[cell], [&](unsigned k) {
      const auto next = neighbours_.at(cell, k);
      if (next < begin || next >= end) return;
      missing_[next] = static_cast<std::uint8_t>(missing_[next] & ~(1U << opposite(k)));
      if (missing_[next] == 0) ready_.push_back(static_cast<std::uint32_t>(next));
    });
  }
}

const Distances& Accumulation::distances(std::size_t cell) const {
  return distances_.size() == 1 ? distances_[0]
                                : distances_[cell / static_cast<std::size_t>(grid_.width)];
}

/// The share of a cell's water that goes to neighbour k, before they are made to add up.
double Accumulation::weight(std::size_t cell, unsigned k) const {
  const unsigned all = cells_.receivers[cell];
  if ((all & (all - 1)) == 0) return 1;
  const double slope = fall(grid_.z[cell], grid_.z[neighbours_.at(cell, k)]) / distances(cell)[k];
  return exponent_ == freeman_exponent ? slope * tenth_root(slope) : bit_pow(slope, exponent_);
}

double Accumulation::all_weights(std::size_t cell) const {
  double sum = 0;
  for_each(cells_.receivers[cell], [&](unsigned k) { sum += weight(cell, k); });
  return sum;
}

void Accumulation::settle_cell(std::size_t cell) {
  const std::size_t row = distances_.size() == 1 ? 0 : cell / static_cast<std::size_t>(grid_.width);
  double area = grid_.area(static_cast<std::int32_t>(row));
  for_each(donors_[cell], [&](unsigned k) {
    const auto donor = neighbours_.at(cell, k);
    area += weight(donor, opposite(k)) * cells_.per_weight[donor];
  });
  cells_.area[cell] = static_cast<float>(area);
  cells_.per_weight[cell] = cells_.receivers[cell] == 0 ? area : area / all_weights(cell);
  ++settled_;
}

Drainage accumulate(const Grid& grid, std::span<const std::uint8_t> receivers, double exponent) {
  Drainage drainage;
  if (grid.size() == 0) return drainage;
  std::vector<double> per_weight(grid.size());
  drainage.area.assign(grid.size(), std::numeric_limits<float>::quiet_NaN());
  Accumulation(grid, {0, grid.height}, exponent).settle({receivers, per_weight, drainage.area});
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    if (grid.valid(cell) && receivers[cell] == 0) drainage.outflow += per_weight[cell];
  }
  return drainage;
}

}  // namespace hoodoo::hydrology
