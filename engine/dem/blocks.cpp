#include "engine/dem/blocks.hpp"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

namespace hoodoo::dem {
namespace {

std::uint32_t block_index(const Layout& layout, std::int64_t column, std::int64_t row) {
  return static_cast<std::uint32_t>(row * layout.across() + column);
}

Error unreadable(const TiffFile& file, const Layout& layout, std::int64_t column, std::int64_t row,
                 const std::string& why) {
  return file.error(Fault::io,
                    fmt::format("cannot be decoded in pixels {} to {}, rows {} to {}{}",
                                column * layout.block_width,
                                std::min(layout.width, (column + 1) * layout.block_width) - 1,
                                row * layout.block_height,
                                std::min(layout.height, (row + 1) * layout.block_height) - 1,
                                why.empty() ? "" : ": " + why));
}

class TiffBlocks : public BlockReader {
 public:
  TiffBlocks(const TiffFile& file, const Layout& layout) : file_(file), layout_(layout) {}

  void read(std::int64_t column, std::int64_t row, std::span<std::byte> out) override {
    const auto block = block_index(layout_, column, row);
    auto expected = static_cast<tmsize_t>(out.size());
    tmsize_t got = 0;
    if (layout_.tiled) {
      got = TIFFReadEncodedTile(file_.get(), block, out.data(), expected);
    } else {
      const auto rows = std::min(layout_.block_height, layout_.height - row * layout_.block_height);
      expected = static_cast<tmsize_t>(rows * layout_.width * layout_.sample_bytes);
      got = TIFFReadEncodedStrip(file_.get(), block, out.data(), expected);
    }
    if (got != expected) throw unreadable(file_, layout_, column, row, "");
  }

 private:
  const TiffFile& file_;
  Layout layout_;
};

class OpenImageIoBlocks : public BlockReader {
 public:
  OpenImageIoBlocks(const TiffFile& file, const Layout& layout,
                    std::unique_ptr<OIIO::ImageInput> input)
      : file_(file), layout_(layout), input_(std::move(input)) {}

  void read(std::int64_t column, std::int64_t row, std::span<std::byte> out) override {
    const auto x = static_cast<int>(column * layout_.block_width);
    const auto y = static_cast<int>(row * layout_.block_height);
    bool good = false;
    if (layout_.tiled) {
      good = input_->read_native_tile(0, 0, x, y, 0, out.data());
    } else {
      const auto end = std::min(layout_.height, (row + 1) * layout_.block_height);
      good = input_->read_native_scanlines(0, 0, y, static_cast<int>(end), 0, out.data());
    }
    if (!good) throw unreadable(file_, layout_, column, row, input_->geterror());
  }

 private:
  const TiffFile& file_;
  Layout layout_;
  std::unique_ptr<OIIO::ImageInput> input_;
};

OIIO::TypeDesc type_of(Sample sample) {
  switch (sample) {
    case Sample::uint8:
      return OIIO::TypeDesc::UINT8;
    case Sample::uint16:
      return OIIO::TypeDesc::UINT16;
    case Sample::int16:
      return OIIO::TypeDesc::INT16;
    case Sample::float32:
      return OIIO::TypeDesc::FLOAT;
    case Sample::float64:
      return OIIO::TypeDesc::DOUBLE;
    default:
      return OIIO::TypeDesc::UNKNOWN;
  }
}

// What was compared with libtiff sample by sample. OpenImageIO 2.4.7 gives zeros or garbage for
// tiled float64, says nothing of 32 and 64 bit integers, and inverts white-is-zero.
bool faithful(const Layout& layout) {
  if (layout.tiled && layout.sample == Sample::float64) return false;
  if (layout.photometric != PHOTOMETRIC_MINISBLACK) return false;
  if (type_of(layout.sample) == OIIO::TypeDesc::UNKNOWN) return false;
  constexpr std::uint16_t compared[] = {COMPRESSION_NONE,    COMPRESSION_LZW,
                                        COMPRESSION_DEFLATE, COMPRESSION_ADOBE_DEFLATE,
                                        COMPRESSION_ZSTD,    COMPRESSION_PACKBITS};
  return std::find(std::begin(compared), std::end(compared), layout.compression) !=
         std::end(compared);
}

}  // namespace

std::unique_ptr<BlockReader> block_reader(const TiffFile& file, const Layout& layout) {
  if (faithful(layout)) {
    // Its own threads would decode strips behind the back of ours.
    [[maybe_unused]] static const bool single = OIIO::attribute("threads", 1);
    auto input = OIIO::ImageInput::create("tiff");
    OIIO::ImageSpec spec;
    const OIIO::ImageSpec wish;
    // A file with a page offset (XPOSITION) numbers its pixels from there: libtiff's job then.
    if (input && input->open(file.path().string(), spec, wish) && spec.width == layout.width &&
        spec.height == layout.height && spec.nchannels == 1 && spec.x == 0 && spec.y == 0 &&
        spec.format == type_of(layout.sample) &&
        spec.tile_width == (layout.tiled ? layout.block_width : 0)) {
      return std::make_unique<OpenImageIoBlocks>(file, layout, std::move(input));
    }
    if (input) static_cast<void>(input->geterror());
  }
  return std::make_unique<TiffBlocks>(file, layout);
}

bool has_block(const TiffFile& file, const Layout& layout, std::int64_t column, std::int64_t row) {
  const auto block = block_index(layout, column, row);
  return TIFFGetStrileOffset(file.get(), block) != 0 ||
         TIFFGetStrileByteCount(file.get(), block) != 0;
}

}  // namespace hoodoo::dem
