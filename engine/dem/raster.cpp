#include "engine/dem/raster.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <list>
#include <nlohmann/json.hpp>
#include <unordered_map>
#include <utility>

#include "engine/dem/blocks.hpp"
#include "engine/dem/georeference.hpp"
#include "engine/dem/tiff.hpp"

namespace hoodoo::dem {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Tells samples without data. The tag is compared in the sample's own precision, for it is
/// printed with more or fewer digits than the samples have; whatever exceeds 1e30 is one of the
/// customary marks (-3.4e38, 1.70141e+38), never an elevation.
template <class T>
struct NoData {
  explicit NoData(std::optional<double> tag) {
    if (!tag || !(std::abs(*tag) < 1e30)) return;
    if constexpr (std::is_floating_point_v<T>) {
      mark = static_cast<T>(*tag);
      given = true;
    } else {
      // One past the largest is exact as a double, the largest itself may not be.
      const double low = static_cast<double>(std::numeric_limits<T>::min());
      const double end = std::ldexp(1.0, std::numeric_limits<T>::digits);
      if (!(*tag >= low && *tag <= end)) return;
      mark = *tag >= end ? std::numeric_limits<T>::max() : static_cast<T>(*tag);
      given = static_cast<double>(mark) == *tag;
    }
  }
  double elevation(T v) const {
    if (given && v == mark) return nan;
    const auto value = static_cast<double>(v);
    return std::abs(value) < 1e30 ? value : nan;
  }
  T mark{};
  bool given = false;
};

template <class T>
void convert(const std::byte* from, std::size_t count, std::optional<double> tag, double* to) {
  const NoData<T> nodata(tag);
  for (std::size_t k = 0; k < count; ++k) {
    T v;
    std::memcpy(&v, from + k * sizeof(T), sizeof(T));
    to[k] = nodata.elevation(v);
  }
}

void convert(Sample sample, const std::byte* from, std::size_t count, std::optional<double> tag,
             double* to) {
  switch (sample) {
    case Sample::uint8:
      return convert<std::uint8_t>(from, count, tag, to);
    case Sample::int8:
      return convert<std::int8_t>(from, count, tag, to);
    case Sample::uint16:
      return convert<std::uint16_t>(from, count, tag, to);
    case Sample::int16:
      return convert<std::int16_t>(from, count, tag, to);
    case Sample::uint32:
      return convert<std::uint32_t>(from, count, tag, to);
    case Sample::int32:
      return convert<std::int32_t>(from, count, tag, to);
    case Sample::uint64:
      return convert<std::uint64_t>(from, count, tag, to);
    case Sample::int64:
      return convert<std::int64_t>(from, count, tag, to);
    case Sample::float32:
      return convert<float>(from, count, tag, to);
    case Sample::float64:
      return convert<double>(from, count, tag, to);
  }
}

class GeoTiff : public Raster {
 public:
  GeoTiff(const std::filesystem::path& path, const RasterLimits& limits)
      : file_(path, limits), layout_(read_layout(file_, limits)) {
    info_.path = path;
    info_.state = file_.state();
    info_.width = layout_.width;
    info_.height = layout_.height;
    info_.sample = to_string(layout_.sample);
    info_.layout = layout_.tiled
                       ? fmt::format("tiled {} x {}", layout_.block_width, layout_.block_height)
                       : fmt::format("striped {} row{}", layout_.block_height,
                                     layout_.block_height == 1 ? "" : "s");
    info_.compression = compression_name(layout_.compression);
    info_.predictor = layout_.predictor;
    info_.big = TIFFIsBigTIFF(file_.get()) != 0;
    read_georeference(file_, info_);
    blocks_ = block_reader(file_, layout_);
  }

  const RasterInfo& info() const override { return info_; }
  void keep(std::size_t bytes) override { keep_ = bytes; }
  Block block() const override {
    return {layout_.block_bytes(), layout_.block_width, layout_.block_height};
  }

  void read(std::int64_t i0, std::int64_t j0, int width, int height,
            std::vector<double>& out) override {
    assert(i0 >= 0 && j0 >= 0 && width > 0 && height > 0 && i0 + width <= layout_.width &&
           j0 + height <= layout_.height);
    out.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (auto row = j0 / layout_.block_height; row * layout_.block_height < j0 + height; ++row) {
      for (auto column = i0 / layout_.block_width; column * layout_.block_width < i0 + width;
           ++column) {
        copy(column, row, i0, j0, width, height, out);
      }
    }
  }

 private:
  struct Decoded {
    std::int64_t index;
    std::vector<std::byte> samples;
  };

  void copy(std::int64_t column, std::int64_t row, std::int64_t i0, std::int64_t j0, int width,
            int height, std::vector<double>& out) {
    static const std::vector<std::byte> none;
    const auto& samples = has_block(file_, layout_, column, row) ? decoded(column, row) : none;
    const auto left = column * layout_.block_width, top = row * layout_.block_height;
    const auto first = std::max(i0, left);
    const auto count =
        static_cast<std::size_t>(std::min(i0 + width, left + layout_.block_width) - first);
    const auto end = std::min(j0 + height, top + layout_.block_height);
    for (auto j = std::max(j0, top); j < end; ++j) {
      double* const to = out.data() + (j - j0) * width + (first - i0);
      if (samples.empty()) {
        std::fill_n(to, count, nan);
        continue;
      }
      const auto at = ((j - top) * layout_.block_width + (first - left)) * layout_.sample_bytes;
      convert(layout_.sample, samples.data() + at, count, info_.nodata, to);
    }
  }

  const std::vector<std::byte>& decoded(std::int64_t column, std::int64_t row) {
    const auto index = row * layout_.across() + column;
    if (const auto found = where_.find(index); found != where_.end()) {
      recent_.splice(recent_.begin(), recent_, found->second);
      return recent_.front().samples;
    }
    Decoded block{index, {}};
    // The memory of the block longest unused serves again.
    while (!recent_.empty() && (recent_.size() + 1) * layout_.block_bytes() > keep_) {
      block.samples = std::move(recent_.back().samples);
      where_.erase(recent_.back().index);
      recent_.pop_back();
    }
    block.samples.resize(layout_.block_bytes());
    blocks_->read(column, row, block.samples);
    recent_.push_front(std::move(block));
    where_[index] = recent_.begin();
    return recent_.front().samples;
  }

  TiffFile file_;
  Layout layout_;
  RasterInfo info_;
  std::unique_ptr<BlockReader> blocks_;
  std::size_t keep_ = 16u << 20;
  std::list<Decoded> recent_;  // the last used in front
  std::unordered_map<std::int64_t, std::list<Decoded>::iterator> where_;
};

std::string kind_name(RasterInfo::Crs kind) {
  switch (kind) {
    case RasterInfo::Crs::geographic:
      return "geographic";
    case RasterInfo::Crs::projected:
      return "projected";
    case RasterInfo::Crs::web_mercator:
      return "web_mercator";
    case RasterInfo::Crs::none:
      break;
  }
  return "none";
}

}  // namespace

std::unique_ptr<Raster> Raster::open(const std::filesystem::path& path,
                                     const RasterLimits& limits) {
  return std::make_unique<GeoTiff>(path, limits);
}

nlohmann::json to_json(const RasterInfo& info) {
  nlohmann::json json = {{"path", info.path.string()},
                         {"width", info.width},
                         {"height", info.height},
                         {"sample", info.sample},
                         {"layout", info.layout},
                         {"compression", info.compression},
                         {"predictor", info.predictor},
                         {"bigtiff", info.big},
                         {"nodata", nullptr},
                         {"pixel_is_point", info.pixel_is_point},
                         {"transform", info.transform},
                         {"kind", kind_name(info.kind)},
                         {"crs", info.crs},
                         {"crs_name", info.crs_name},
                         {"unit", info.unit},
                         {"vertical_unit", info.vertical_unit},
                         {"vertical", info.vertical}};
  if (info.nodata) {
    // JSON has no NaN or infinity.
    json["nodata"] = std::isfinite(*info.nodata) ? nlohmann::json(*info.nodata)
                                                 : nlohmann::json(fmt::format("{}", *info.nodata));
  }
  return json;
}

}  // namespace hoodoo::dem
