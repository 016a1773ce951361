#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace hoodoo::hydrology {

/// Exact percentiles of the first band of a raster by nearest rank: of the values that are there,
/// the least that so many per cent of them do not exceed. Reads the file twice, block by block, and
/// holds a row. `percents` in [0, 100].
///
/// One NaN for each if the raster has no value. Errors: as dem::Raster.
std::vector<float> percentiles(const std::filesystem::path& raster,
                               std::span<const double> percents);

}  // namespace hoodoo::hydrology
