#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "engine/base/error.hpp"
#include "engine/hydrology/basins.hpp"
#include "engine/hydrology/large.hpp"
#include "engine/hydrology/sinks.hpp"

namespace hoodoo::hydrology {
namespace {

/// A raster's parts as one graph: of the basins that are cells along borders, and the outside.
class Borders {
 public:
  /// The basins of the next part: the cells of its borders get the next numbers.
  void add(Basins& part, std::uint32_t kept) {
    for (const auto& pass : contracted(part.passes(), part.count(), kept)) {
      passes_.push_back({number(pass.a), number(pass.b), pass.level});
    }
    first_.push_back(first_.back() + kept - 1);
  }
  /// Where the part's last row meets the first of the next one.
  void join(std::span<const float> last, std::span<const std::uint32_t> last_numbers,
            std::span<const float> first, std::span<const std::uint32_t> first_numbers) {
    for (std::size_t i = 0; i < last.size(); ++i) {
      for (std::size_t k = i == 0 ? 0 : i - 1; k <= i + 1 && k < first.size(); ++k) {
        const auto a = last_numbers[i], b = first_numbers[k];
        if (a != b) passes_.push_back({a, b, higher(last[i], first[k])});
      }
    }
  }
  void solve() { levels_ = spill_levels(passes_, first_.back() + 1), passes_ = {}; }
  /// Of a basin of a part's border.
  float level(std::size_t part, std::uint32_t basin) const { return levels_[first_[part] + basin]; }
  /// Of a basin of the part that is added next.
  std::uint32_t number(std::uint32_t basin) const {
    return basin == outside ? outside : first_.back() + basin;
  }

 private:
  std::vector<std::uint32_t> first_{0};  // of each part, less one
  std::vector<Pass> passes_;
  std::vector<float> levels_;
};

/// One row along a border, with its numbers in the graph.
struct BorderRow {
  std::vector<float> z;
  std::vector<std::uint32_t> numbers;
};
BorderRow border_row(std::span<const float> z, std::size_t row, std::size_t width,
                     const Basins& basins, const Borders& borders) {
  BorderRow result;
  for (std::size_t i = 0; i < width; ++i) {
    result.z.push_back(z[row * width + i]);
    result.numbers.push_back(borders.number(basins.at(row * width + i)));
  }
  return result;
}

}  // namespace

void LargeDem::fill() {
  if (filled_) return;
  filled_ = std::make_unique<Scratch>(folder_);
  const auto all = parts(rows_to_fill(memory_));
  const auto width = static_cast<std::size_t>(width_);
  const auto ground_of = [&](const Rows& rows, std::vector<float>& z) {
    z.resize(cells(rows.to - rows.from));
    elevations_.read<float>(cell(rows.from), z);
    return Ground{z, width, rows.from > 0, rows.to < height_};
  };
  Borders borders;
  std::vector<float> z;
  BorderRow last;
  for (const auto& rows : all) {
    if (all.size() == 1) break;
    const auto ground = ground_of(rows, z);
    Basins basins(ground);
    const auto first = border_row(z, 0, width, basins, borders);
    if (ground.above) borders.join(last.z, last.numbers, first.z, first.numbers);
    last = border_row(z, ground.height() - 1, width, basins, borders);
    borders.add(basins, basins.on_borders());
  }
  borders.solve();
  for (std::size_t n = 0; n < all.size(); ++n) {
    Basins basins(ground_of(all[n], z));
    // Along the borders water leaves at levels that are known.
    for (std::uint32_t b = 1; b < basins.on_borders(); ++b) {
      basins.passes().push_back({outside, b, borders.level(n, b)});
    }
    basins.raise(spill_levels(basins.passes(), basins.count()));
    filled_->write<float>(cell(all[n].from), z);
  }
}

void LargeDem::filled(const TakeRows& take) {
  fill();
  std::vector<float> z(static_cast<std::size_t>(width_));
  for (std::int32_t j = 0; j < height_; ++j) {
    filled_->read<float>(cell(j), z);
    take(z);
  }
}

std::vector<Sink> LargeDem::sinks() {
  fill();
  const auto wide = static_cast<std::size_t>(width_);
  std::vector<float> z(wide), filled(wide);
  SinkFinder finder(width_);
  for (std::int32_t j = 0; j < height_; ++j) {
    elevations_.read<float>(cell(j), z);
    filled_->read<float>(cell(j), filled);
    const auto row = static_cast<std::size_t>(j);
    finder.add(z, filled, dx_[row] * dy_[row]);
    if (finder.bytes() <= memory_) continue;
    throw Error(Fault::limit, dem_.string(),
                fmt::format("has so many pits that those of its first {} of {} rows need {} MiB of "
                            "memory; {} are allowed",
                            j + 1, height_, (finder.bytes() >> 20) + 1, memory_ >> 20));
  }
  return finder.finish();
}

}  // namespace hoodoo::hydrology
