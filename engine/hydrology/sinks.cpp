#include "engine/hydrology/sinks.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace hoodoo::hydrology {
namespace {

constexpr float hole = std::numeric_limits<float>::quiet_NaN();

/// Of the eight neighbours those that come before a cell in the order of rows: three above, one
/// beside it.
struct Before {
  bool above;
  std::ptrdiff_t by;
};
constexpr std::array<Before, 4> before{{{true, -1}, {true, 0}, {true, 1}, {false, -1}}};

std::size_t beside(std::size_t i, std::ptrdiff_t by) {
  return static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + by);
}

}  // namespace

SinkFinder::SinkFinder(std::int32_t width)
    : width_(static_cast<std::size_t>(width)), above_(row_of({}, {}, 0)) {}

SinkFinder::Row SinkFinder::row_of(std::span<const float> z, std::span<const float> filled,
                                   double area) const {
  Row row;
  row.z.assign(width_ + 2, hole);
  row.filled.assign(width_ + 2, hole);
  std::ranges::copy(z, row.z.begin() + 1);
  std::ranges::copy(filled, row.filled.begin() + 1);
  row.bottom.assign(width_ + 2, none);
  row.water.assign(width_ + 2, none);
  row.area = area;
  return row;
}

void SinkFinder::add(std::span<const float> z, std::span<const float> filled, double area) {
  auto below = row_of(z, filled, area);
  if (any_) {
    find_sets(below);
    above_ = std::move(now_);
    ++row_;
  }
  now_ = std::move(below);
  any_ = true;
}

/// Puts the cells of the row at hand into sets, which takes the rows above and below it.
void SinkFinder::find_sets(const Row& below) {
  for (std::size_t i = 1; i <= width_; ++i) {
    if (now_.filled[i] > now_.z[i]) place_in_water(i);
    if (is_low(i, below)) {
      place_on_bottom(i);
      continue;
    }
    for (const auto& [above, by] : before) {
      const Row& row = above ? above_ : now_;
      const auto set = row.bottom[beside(i, by)];
      if (set != none && row.z[beside(i, by)] == now_.z[i]) bottom_[bottoms_.of(set)].leaks = true;
    }
  }
}

/// All neighbours have elevations, none a lower one.
bool SinkFinder::is_low(std::size_t i, const Row& below) const {
  const float z = now_.z[i];
  for (const auto* row : {&above_, &now_, &below}) {
    for (std::size_t k = i - 1; k <= i + 1; ++k) {
      if (!(row->z[k] >= z)) return false;
    }
  }
  return true;
}

void SinkFinder::place_in_water(std::size_t i) {
  auto set = none;
  for (const auto& [above, by] : before) {
    const auto other = (above ? above_ : now_).water[beside(i, by)];
    if (other == none) continue;
    const auto root = waters_.of(other);
    set = set == none ? root : join_waters(set, root);
  }
  if (set == none) {
    set = waters_.add();
    areas_.push_back(0);
  }
  areas_[set] += now_.area;
  now_.water[i] = set;
}

void SinkFinder::place_on_bottom(std::size_t i) {
  auto set = none;
  bool leaks = false;
  for (const auto& [above, by] : before) {
    const Row& row = above ? above_ : now_;
    const auto n = beside(i, by);
    if (row.z[n] != now_.z[i]) continue;
    if (row.bottom[n] == none) {
      leaks = true;
      continue;
    }
    const auto root = bottoms_.of(row.bottom[n]);
    set = set == none ? root : join_bottoms(set, root);
  }
  if (set == none) {
    set = bottoms_.add();
    bottom_.push_back(
        {static_cast<std::int32_t>(i - 1), row_, now_.z[i], now_.filled[i], now_.water[i], false});
  }
  bottom_[set].leaks = bottom_[set].leaks || leaks;
  now_.bottom[i] = set;
}

std::uint32_t SinkFinder::join_bottoms(std::uint32_t a, std::uint32_t b) {
  const auto [low, high] = std::minmax(a, b);
  bottom_[low].leaks = bottom_[low].leaks || bottom_[high].leaks;
  bottoms_.join(low, high);
  return low;
}

std::uint32_t SinkFinder::join_waters(std::uint32_t a, std::uint32_t b) {
  const auto [low, high] = std::minmax(a, b);
  if (low == high) return low;
  areas_[low] += areas_[high];
  waters_.join(low, high);
  return low;
}

std::vector<Sink> SinkFinder::finish() {
  if (any_) find_sets(row_of({}, {}, 0));
  std::vector<Sink> sinks;
  for (std::uint32_t n = 0; n < bottom_.size(); ++n) {
    const auto& bottom = bottom_[n];
    if (bottoms_.of(n) != n || bottom.leaks) continue;
    sinks.push_back({bottom.i, bottom.j, bottom.z,
                     static_cast<double>(bottom.filled) - static_cast<double>(bottom.z),
                     bottom.water == none ? 0 : areas_[waters_.of(bottom.water)]});
  }
  return sinks;
}

std::size_t SinkFinder::bytes() const {
  return bottom_.size() * (sizeof(Bottom) + sizeof(std::uint32_t) + sizeof(Sink)) +
         waters_.size() * (sizeof(double) + sizeof(std::uint32_t));
}

std::vector<Sink> sinks(const Grid& grid, const Grid& filled) {
  SinkFinder finder(grid.width);
  const auto width = static_cast<std::size_t>(grid.width);
  for (std::int32_t j = 0; j < grid.height; ++j) {
    const auto row = [&](const Grid& of) {
      return std::span(of.z).subspan(grid.index(0, j), width);
    };
    finder.add(row(grid), row(filled), grid.area(j));
  }
  return finder.finish();
}

}  // namespace hoodoo::hydrology
