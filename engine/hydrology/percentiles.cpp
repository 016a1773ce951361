#include "engine/hydrology/percentiles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "engine/dem/raster.hpp"

namespace hoodoo::hydrology {
namespace {

/// A number that sorts as the value does.
std::uint32_t key_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return (bits >> 31) != 0 ? ~bits : bits | 0x80000000U;
}
float value_of(std::uint32_t key) {
  return std::bit_cast<float>((key >> 31) != 0 ? key & 0x7fffffffU : ~key);
}

/// Rows of tiles are read as blocks of as many rows, so that each tile is decoded once.
template <class Visit>
void for_each_key(dem::Raster& raster, Visit visit) {
  const auto& info = raster.info();
  const auto block = raster.block();
  std::vector<double> values;
  for (std::int64_t j = 0; j < info.height; j += block.height) {
    const auto high = std::min(block.height, info.height - j);
    for (std::int64_t i = 0; i < info.width; i += block.width) {
      const auto wide = std::min(block.width, info.width - i);
      raster.read(i, j, static_cast<int>(wide), static_cast<int>(high), values);
      for (const double value : values) {
        if (!std::isnan(value)) visit(key_of(static_cast<float>(value)));
      }
    }
  }
}

constexpr std::size_t halves = std::size_t{1} << 16;

/// The bucket in which the number of this rank lies, and its rank there; ranks start at 1.
struct Place {
  std::size_t bucket;
  std::uint64_t rank;
};
Place find(std::span<const std::uint64_t> counts, std::uint64_t rank) {
  std::size_t bucket = 0;
  while (counts[bucket] < rank) rank -= counts[bucket++];
  return {bucket, rank};
}

}  // namespace

std::vector<float> percentiles(const std::filesystem::path& file,
                               std::span<const double> percents) {
  const auto raster = dem::Raster::open(file);
  std::vector<std::uint64_t> counts(halves);
  std::uint64_t all = 0;
  for_each_key(*raster, [&](std::uint32_t key) { ++counts[key >> 16], ++all; });
  if (all == 0) return std::vector(percents.size(), std::numeric_limits<float>::quiet_NaN());
  // By their upper halves first; then those of the same upper half by the lower.
  std::vector<Place> places;
  std::vector<std::size_t> numbers(halves);  // of the lists of `lower`, from 1
  std::vector<std::vector<std::uint64_t>> lower;
  for (const double percent : percents) {
    const auto rank =
        static_cast<std::uint64_t>(std::ceil(percent * static_cast<double>(all) / 100));
    places.push_back(find(counts, std::clamp<std::uint64_t>(rank, 1, all)));
    auto& number = numbers[places.back().bucket];
    if (number != 0) continue;
    lower.emplace_back(halves);
    number = lower.size();
  }
  for_each_key(*raster, [&](std::uint32_t key) {
    const auto number = numbers[key >> 16];
    if (number != 0) ++lower[number - 1][key & 0xffffU];
  });
  std::vector<float> values;
  for (const auto& place : places) {
    const auto low = find(lower[numbers[place.bucket] - 1], place.rank).bucket;
    values.push_back(value_of(static_cast<std::uint32_t>(place.bucket << 16 | low)));
  }
  return values;
}

}  // namespace hoodoo::hydrology
