#include "engine/generator/disk_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <unordered_map>

#include "engine/base/error.hpp"
#include "engine/base/random.hpp"

namespace hoodoo::generator {
namespace {

constexpr std::size_t rounds = 12;      // candidates of a cell
constexpr std::int64_t block = 64;      // cells along a block; one block is one task
constexpr std::int64_t page_side = 16;  // cells along a page of what is known of them
constexpr double most_cells = 4e8;
constexpr double farthest_cell = 1e9;

std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  return a >= 0 ? a / b : -((b - 1 - a) / b);
}

struct Candidate {
  double x, y;
  std::uint64_t key;
};

enum class State : std::uint8_t { unknown, no, yes };
using Page = std::array<std::array<State, rounds>, page_side * page_side>;

/// Judges candidates, and remembers them.
class Judge {
 public:
  explicit Judge(const DiskSampling& sampling)
      : sampling_(sampling),
        cell_(sampling.least / std::sqrt(2.0)),
        reach_(static_cast<std::int64_t>(std::ceil(sampling.most / cell_))) {}

  double cell() const { return cell_; }

  Candidate candidate(std::int64_t i, std::int64_t j, std::size_t round) const {
    const auto key = random_bits(sampling_.seed, i, j, round);
    return {(static_cast<double>(i) + unit_real(mix(key + 1))) * cell_,
            (static_cast<double>(j) + unit_real(mix(key + 2))) * cell_, key};
  }

  bool is_sample(std::int64_t i, std::int64_t j, std::size_t round, const Candidate& c) {
    State* known = state(i, j, round);
    if (*known == State::unknown) {
      const bool yes = is_free(i, j, round, c);
      known = state(i, j, round);
      *known = yes ? State::yes : State::no;
    }
    return *known == State::yes;
  }

 private:
  /// No sample that is judged before it is too near.
  bool is_free(std::int64_t i, std::int64_t j, std::size_t round, const Candidate& c) {
    const double own = distance(c);
    for (std::size_t r = 0; r <= round; ++r) {
      for (std::int64_t b = j - reach_; b <= j + reach_; ++b) {
        for (std::int64_t a = i - reach_; a <= i + reach_; ++a) {
          if (a == i && b == j && r == round) continue;
          const auto other = candidate(a, b, r);
          if (r == round && other.key >= c.key) continue;
          const double dx = other.x - c.x, dy = other.y - c.y, d2 = dx * dx + dy * dy;
          if (d2 >= sampling_.most * sampling_.most) continue;
          const double apart = sampling_.distance ? (own + distance(other)) / 2 : own;
          if (d2 < apart * apart && is_sample(a, b, r, other)) return false;
        }
      }
    }
    return true;
  }

  double distance(const Candidate& c) const {
    if (!sampling_.distance) return sampling_.least;
    return std::clamp(sampling_.distance(c.x, c.y), sampling_.least, sampling_.most);
  }

  State* state(std::int64_t i, std::int64_t j, std::size_t round) {
    const auto a = floor_div(i, page_side), b = floor_div(j, page_side);
    if (page_ == nullptr || a != page_i_ || b != page_j_) {
      auto& page = pages_[random_bits(static_cast<std::uint64_t>(a), b)];
      if (!page) page = std::make_unique<Page>();
      page_ = page.get();
      page_i_ = a;
      page_j_ = b;
    }
    const auto cell = static_cast<std::size_t>((j - b * page_side) * page_side + i - a * page_side);
    return &(*page_)[cell][round];
  }

  const DiskSampling& sampling_;
  double cell_;
  std::int64_t reach_;
  std::unordered_map<std::uint64_t, std::unique_ptr<Page>> pages_;
  Page* page_ = nullptr;  // the last one asked for
  std::int64_t page_i_ = 0, page_j_ = 0;
};

}  // namespace

std::vector<DiskSample> sample_disks(const Site& site, const DiskSampling& sampling) {
  const Box& box = sampling.box;
  if (!(box.min.x <= box.max.x && box.min.y <= box.max.y)) return {};
  const double cell = Judge(sampling).cell();
  const auto at = [&](double v) { return std::floor(v / cell); };
  const double wide = at(box.max.x) - at(box.min.x) + 1, high = at(box.max.y) - at(box.min.y) + 1;
  const double far = std::max({std::abs(at(box.min.x)), std::abs(at(box.max.x)),
                               std::abs(at(box.min.y)), std::abs(at(box.max.y))});
  if (wide * high > most_cells || far > farthest_cell) {
    throw Error(Fault::limit, "/distance",
                fmt::format("samples {} m apart over {:.0f} x {:.0f} m are too many: make the "
                            "region smaller or the distance larger",
                            sampling.least, box.max.x - box.min.x, box.max.y - box.min.y));
  }
  const auto i0 = static_cast<std::int64_t>(at(box.min.x)),
             i1 = static_cast<std::int64_t>(at(box.max.x)),
             j0 = static_cast<std::int64_t>(at(box.min.y)),
             j1 = static_cast<std::int64_t>(at(box.max.y));
  const auto bi0 = floor_div(i0, block), bi1 = floor_div(i1, block), bj0 = floor_div(j0, block),
             bj1 = floor_div(j1, block);
  const auto across = static_cast<std::size_t>(bi1 - bi0 + 1);
  std::vector<std::vector<DiskSample>> found(across * static_cast<std::size_t>(bj1 - bj0 + 1));
  site.in_parallel(found.size(), [&](std::size_t n) {
    Judge judge(sampling);
    const auto bi = bi0 + static_cast<std::int64_t>(n % across);
    const auto bj = bj0 + static_cast<std::int64_t>(n / across);
    for (auto j = std::max(j0, bj * block); j <= std::min(j1, bj * block + block - 1); ++j) {
      for (auto i = std::max(i0, bi * block); i <= std::min(i1, bi * block + block - 1); ++i) {
        for (std::size_t round = 0; round < rounds; ++round) {
          const auto c = judge.candidate(i, j, round);
          const bool inside =
              c.x >= box.min.x && c.x <= box.max.x && c.y >= box.min.y && c.y <= box.max.y;
          if (!inside || (sampling.wanted && !sampling.wanted(c.x, c.y, c.key))) continue;
          if (judge.is_sample(i, j, round, c)) found[n].push_back({c.x, c.y, c.key});
        }
      }
    }
  });
  std::vector<DiskSample> samples;
  for (const auto& some : found) samples.insert(samples.end(), some.begin(), some.end());
  return samples;
}

}  // namespace hoodoo::generator
