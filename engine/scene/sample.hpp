#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

namespace hoodoo::scene {

/// A made-up coast of pixels^2 samples. Its first kilometre, from the south-west corner, is always
/// laid out alike: sea in the west, a cliff up to a plateau, a headland that ends before a sea
/// stack, and a valley that comes down to a beach. Further on the coast, the plateau and the
/// valley continue, and hills rise inland.
struct SampleDem {
  int pixels = 500;        // along either side, 1 to 65536
  double spacing = 2;      // [m]
  std::uint32_t seed = 1;  // of the noise; the layout stays
};

/// Elevations [m] at the centres of one row's pixels; rows run south to north.
std::vector<double> sample_row(const SampleDem& sample, int row);

/// Writes the sample as a GeoTIFF: float32, tiles of 256^2, deflate, EPSG:32612. One row of tiles
/// is in memory at a time. The same bytes for the same sample and zlib. The file appears whole or
/// not at all. Errors: bad_input, io.
void write_sample_dem(const std::filesystem::path& path, const SampleDem& sample);

}  // namespace hoodoo::scene
