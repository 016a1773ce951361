#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "engine/hydrology/accumulation.hpp"
#include "engine/hydrology/large.hpp"
#include "engine/hydrology/router.hpp"

namespace hoodoo::hydrology {
namespace {

/// Parts of which something near has changed since they were visited: down and up again, until
/// there are none.
class Visits {
 public:
  Visits(std::size_t parts, std::size_t reach) : stale_(parts, 1), reach_(reach) {}

  /// visit(part) tells whether it changed anything.
  template <class Visit>
  void run(Visit visit) {
    while (std::ranges::find(stale_, 1) != stale_.end()) {
      for (std::size_t n = 0; n < stale_.size(); ++n) one(n, visit);
      for (std::size_t n = stale_.size(); n-- > 0;) one(n, visit);
    }
  }

 private:
  template <class Visit>
  void one(std::size_t n, Visit& visit) {
    if (stale_[n] == 0) return;
    stale_[n] = 0;
    if (!visit(n)) return;
    const std::size_t end = std::min(n + reach_ + 1, stale_.size());
    for (std::size_t m = n < reach_ ? 0 : n - reach_; m < end; ++m) {
      if (m != n) stale_[m] = 1;
    }
  }

  std::vector<char> stale_;
  std::size_t reach_;  // so many parts before and after one are near it
};

}  // namespace

void LargeDem::route(Routing routing) {
  Scratch steps(folder_);
  receivers_ = std::make_unique<Scratch>(folder_);
  const auto all = parts();
  bool flat = false;
  for (const auto& rows : all) {
    const auto part = part_of(*filled_, rows, 1);
    std::vector<std::uint8_t> to(part.grid.size());
    std::vector<std::uint32_t> away(part.grid.size());
    Router(part.grid, part.rows, routing).descend(to, away);
    const auto first = cells(part.rows.from), count = cells(rows.to - rows.from);
    receivers_->write<std::uint8_t>(cell(rows.from), std::span(to).subspan(first, count));
    steps.write<std::uint32_t>(cell(rows.from), std::span(away).subspan(first, count));
    flat = flat || std::ranges::find(away, far_away) != away.end();
  }
  if (flat) cross_flats(routing, steps);
}

void LargeDem::cross_flats(Routing routing, Scratch& steps) {
  const auto all = parts();
  const auto read_steps = [&](const Part& part) {
    std::vector<std::uint32_t> away(part.grid.size());
    steps.read<std::uint32_t>(cell(part.first), away);
    return away;
  };
  std::vector<char> without(all.size());
  Visits(all.size(), 1).run([&](std::size_t n) {
    if (without[n] != 0) return false;
    const auto part = part_of(*filled_, all[n], 1);
    auto away = read_steps(part);
    without[n] = std::ranges::all_of(away, [](auto a) { return a == 0; }) ? 1 : 0;
    const auto before = away;
    Router(part.grid, part.rows, routing).cross(away);
    steps.write<std::uint32_t>(cell(part.first), std::span<const std::uint32_t>(away));
    return away != before;
  });
  for (const auto& rows : all) {
    const auto part = part_of(*filled_, rows, 1);
    const auto away = read_steps(part);
    std::vector<std::uint8_t> to(part.grid.size());
    receivers_->read<std::uint8_t>(cell(part.first), to);
    Router(part.grid, part.rows, routing).choose_on_flats(to, away);
    receivers_->write<std::uint8_t>(
        cell(rows.from), std::span<const std::uint8_t>(to).subspan(cells(part.rows.from),
                                                                   cells(rows.to - rows.from)));
  }
}

/// Windows overlap by half, so that water that goes to and fro across a border is followed.
void LargeDem::settle_all(double exponent, Scratch& per_weight) {
  const auto most = rows_that_fit(memory_, bytes_to_work);
  const auto step = most >= height_ ? most : std::max(most / 2, 1);
  std::vector<Rows> windows;
  for (std::int32_t j = 0; j == 0 || j + most - step < height_; j += step) {
    windows.push_back({j, std::min(j + most, height_)});
  }
  std::vector<char> done(windows.size());
  Visits(windows.size(), 3).run([&](std::size_t n) {
    if (done[n] != 0) return false;
    const Settled cells = settle(windows[n], exponent, per_weight);
    done[n] = cells.left == 0 ? 1 : 0;
    return cells.now > 0;
  });
}

LargeDem::Settled LargeDem::settle(Rows rows, double exponent, Scratch& per_weight) {
  const auto part = part_of(*filled_, rows, 1);
  std::vector<std::uint8_t> to(part.grid.size());
  std::vector<double> weighted(part.grid.size());
  std::vector<float> area(part.grid.size());
  receivers_->read<std::uint8_t>(cell(part.first), to);
  per_weight.read<double>(cell(part.first), weighted);
  area_->read<float>(cell(part.first), area);
  Accumulation accumulation(part.grid, part.rows, exponent);
  const auto settled = accumulation.settle({to, weighted, area});
  const auto first = cells(part.rows.from), count = cells(rows.to - rows.from);
  std::size_t left = 0;
  for (std::size_t c = first; c < first + count; ++c) {
    if (!part.grid.valid(c)) {
      area[c] = std::numeric_limits<float>::quiet_NaN();
    } else if (weighted[c] == 0) {
      ++left;
    }
  }
  per_weight.write<double>(cell(rows.from),
                           std::span<const double>(weighted).subspan(first, count));
  area_->write<float>(cell(rows.from), std::span<const float>(area).subspan(first, count));
  return {settled, left};
}

/// In the order of cells, as of a whole grid.
double LargeDem::outflow(const Scratch& per_weight) const {
  double sum = 0;
  const auto wide = static_cast<std::size_t>(width_);
  std::vector<float> z(wide);
  std::vector<std::uint8_t> to(wide);
  std::vector<double> weighted(wide);
  for (std::int32_t j = 0; j < height_; ++j) {
    filled_->read<float>(cell(j), z);
    receivers_->read<std::uint8_t>(cell(j), to);
    per_weight.read<double>(cell(j), weighted);
    for (std::size_t i = 0; i < wide; ++i) {
      if (!std::isnan(z[i]) && to[i] == 0) sum += weighted[i];
    }
  }
  return sum;
}

double LargeDem::accumulate(const Flow& flow) {
  fill();
  route(flow.routing);
  area_ = std::make_unique<Scratch>(folder_);
  Scratch per_weight(folder_);
  settle_all(flow.exponent, per_weight);
  const double leaves = outflow(per_weight);
  receivers_.reset();
  return leaves;
}

void LargeDem::area(const TakeRows& take) {
  assert(area_);
  std::vector<float> row(static_cast<std::size_t>(width_));
  for (std::int32_t j = 0; j < height_; ++j) {
    area_->read<float>(cell(j), row);
    take(row);
  }
}

void LargeDem::stream_power(const TakeRows& take) {
  assert(area_);
  std::int32_t row = 0;
  slope([&](std::span<const float> slopes) {
    Drainage drainage;
    drainage.area.resize(slopes.size());
    area_->read<float>(cell(row), drainage.area);
    row += static_cast<std::int32_t>(slopes.size() / static_cast<std::size_t>(width_));
    take(hydrology::stream_power(drainage, slopes));
  });
}

}  // namespace hoodoo::hydrology
