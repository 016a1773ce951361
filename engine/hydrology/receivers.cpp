#include <algorithm>
#include <bit>
#include <utility>

#include "engine/hydrology/distance.hpp"
#include "engine/hydrology/router.hpp"

namespace hoodoo::hydrology {
namespace {

/// Of cells with all eight neighbours; no branches, so that several are done at once.
void find_lower(const float* above, const float* here, const float* below, std::size_t width,
                std::uint8_t* lower) {
  for (std::size_t i = 1; i + 1 < width; ++i) {
    const float z = here[i];
    const auto bit = [z](float other, int k) { return static_cast<int>(other < z) << k; };
    lower[i] = static_cast<std::uint8_t>(
        bit(here[i + 1], 0) | bit(above[i + 1], 1) | bit(above[i], 2) | bit(above[i - 1], 3) |
        bit(here[i - 1], 4) | bit(below[i - 1], 5) | bit(below[i], 6) | bit(below[i + 1], 7));
  }
}

/// visit(neighbour) of those on the same flat that are fewer steps from its outlet than it.
template <class Visit>
void for_level(const Grid& grid, const Neighbours& neighbours, std::size_t cell, Visit visit) {
  const unsigned inside = neighbours.inside(cell);
  for (unsigned k = 0; k < 8; ++k) {
    if ((inside >> k & 1) == 0) continue;
    const auto other = neighbours.at(cell, k);
    if (grid.z[other] == grid.z[cell]) visit(other, k);
  }
}

}  // namespace

void Router::descend(std::span<std::uint8_t> receivers, std::span<std::uint32_t> steps) {
  const auto wide = static_cast<std::size_t>(grid_.width);
  for (std::int32_t j = rows_.from; j < rows_.to; ++j) {
    const std::size_t first = grid_.index(0, j);
    descend_row(j, receivers.data() + first);
    for (std::size_t cell = first; cell < first + wide; ++cell) {
      const unsigned lower = receivers[cell];
      const bool flat = lower == 0 && grid_.valid(cell) && neighbours_.valid(cell) == 0xff;
      steps[cell] = flat ? far_away : 0;
      if (routing_ == Routing::d8) receivers[cell] = chosen(cell, lower);
    }
  }
}

void Router::descend_row(std::int32_t j, std::uint8_t* lower) const {
  const std::size_t first = grid_.index(0, j);
  const auto wide = static_cast<std::size_t>(grid_.width);
  if (j == 0 || j + 1 == grid_.height) {
    for (std::size_t i = 0; i < wide; ++i) {
      lower[i] = static_cast<std::uint8_t>(lower_by_one(first + i));
    }
    return;
  }
  const float* here = grid_.z.data() + first;
  find_lower(here - wide, here, here + wide, wide, lower);
  lower[0] = static_cast<std::uint8_t>(lower_by_one(first));
  lower[wide - 1] = static_cast<std::uint8_t>(lower_by_one(first + wide - 1));
}

unsigned Router::lower_by_one(std::size_t cell) const {
  const unsigned inside = neighbours_.inside(cell);
  unsigned lower = 0;
  for (unsigned k = 0; k < 8; ++k) {
    if ((inside >> k & 1) == 0) continue;
    lower |= static_cast<unsigned>(grid_.z[neighbours_.at(cell, k)] < grid_.z[cell]) << k;
  }
  return lower;
}

/// Step by step from the outlets, and from the rows beyond where those are nearer.
void Router::cross(std::span<std::uint32_t> steps) {
  using Start = std::pair<std::uint32_t, std::uint32_t>;  // steps, cell
  std::vector<Start> starts;
  for (std::size_t cell = begin(); cell < end(); ++cell) {
    if (steps[cell] == 0) continue;
    std::uint32_t least = far_away - 1;
    for_level(grid_, neighbours_, cell,
              [&](std::size_t other, unsigned) { least = std::min(least, steps[other]); });
    if (least + 1 < steps[cell]) starts.emplace_back(least + 1, static_cast<std::uint32_t>(cell));
  }
  std::ranges::sort(starts);
  std::vector<std::uint32_t> front, next;
  std::size_t started = 0;
  for (std::uint32_t step = 0; !front.empty() || started < starts.size(); ++step) {
    if (front.empty()) step = starts[started].first;
    for (; started < starts.size() && starts[started].first == step; ++started) {
      const auto cell = starts[started].second;
      if (step < steps[cell]) steps[cell] = step, front.push_back(cell);
    }
    next.clear();
    for (const std::size_t cell : front) {
      for_level(grid_, neighbours_, cell, [&](std::size_t other, unsigned) {
        if (other < begin() || other >= end() || steps[other] <= step + 1) return;
        steps[other] = step + 1;
        next.push_back(static_cast<std::uint32_t>(other));
      });
    }
    front.swap(next);
  }
}

void Router::choose_on_flats(std::span<std::uint8_t> receivers,
                             std::span<const std::uint32_t> steps) {
  for (std::size_t cell = begin(); cell < end(); ++cell) {
    if (steps[cell] == 0 || steps[cell] == far_away) continue;
    unsigned nearer = 0;
    for_level(grid_, neighbours_, cell, [&](std::size_t other, unsigned k) {
      nearer |= static_cast<unsigned>(steps[other] + 1 == steps[cell]) << k;
    });
    receivers[cell] = chosen(cell, nearer);
  }
}

std::uint8_t Router::chosen(std::size_t cell, unsigned candidates) const {
  if (routing_ == Routing::d8 && candidates != 0) candidates = 1U << steepest(cell, candidates);
  return static_cast<std::uint8_t>(candidates);
}

unsigned Router::steepest(std::size_t cell, unsigned candidates) const {
  if (std::has_single_bit(candidates)) return static_cast<unsigned>(std::countr_zero(candidates));
  const auto wide = static_cast<std::size_t>(grid_.width);
  const Distances distances(grid_, static_cast<std::int32_t>(cell / wide));
  double most = -1;
  unsigned best = 0;
  for (unsigned k = 0; k < 8; ++k) {
    if ((candidates >> k & 1) == 0) continue;
    const double drop = fall(grid_.z[cell], grid_.z[neighbours_.at(cell, k)]) / distances[k];
    if (drop > most) most = drop, best = k;
  }
  return best;
}

std::vector<std::uint8_t> receivers(const Grid& grid, Routing routing) {
  std::vector<std::uint8_t> result(grid.size());
  if (result.empty()) return result;
  std::vector<std::uint32_t> steps(grid.size());
  Router router(grid, {0, grid.height}, routing);
  router.descend(result, steps);
  router.cross(steps);
  router.choose_on_flats(result, steps);
  return result;
}

}  // namespace hoodoo::hydrology
