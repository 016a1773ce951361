#include "engine/dem/blocks.hpp"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <utility>

namespace hoodoo::dem {
namespace {

std::uint32_t block_index(const Layout& layout, std::int64_t column, std::int64_t row) {
  return static_cast<std::uint32_t>(row * layout.across() + column);
}

Error unreadable(const TiffFile& file, const Layout& layout, std::int64_t column,
                 std::int64_t row) {
  const auto block = block_index(layout, column, row);
  const auto end =
      TIFFGetStrileOffset(file.get(), block) + TIFFGetStrileByteCount(file.get(), block);
  const bool cut = end > file.bytes();
  const bool unread = errno == EIO || errno == ESTALE;
  return file.error(unread ? Fault::io : Fault::bad_input,
                    fmt::format("{}cannot be decoded in pixels {} to {}, rows {} to {}",
                                cut ? "is cut short: " : "", column * layout.block_width,
                                std::min(layout.width, (column + 1) * layout.block_width) - 1,
                                row * layout.block_height,
                                std::min(layout.height, (row + 1) * layout.block_height) - 1));
}

class TiffBlocks : public BlockReader {
 public:
  TiffBlocks(const TiffFile& file, const Layout& layout) : file_(file), layout_(layout) {}

  void read(std::int64_t column, std::int64_t row, std::span<std::byte> out) override {
    const auto block = block_index(layout_, column, row);
    auto expected = static_cast<tmsize_t>(out.size());
    tmsize_t got = 0;
    errno = 0;
    if (layout_.tiled) {
      got = TIFFReadEncodedTile(file_.get(), block, out.data(), expected);
    } else {
      const auto rows = std::min(layout_.block_height, layout_.height - row * layout_.block_height);
      expected = static_cast<tmsize_t>(rows * layout_.width * layout_.sample_bytes);
      got = TIFFReadEncodedStrip(file_.get(), block, out.data(), expected);
    }
    if (got != expected) throw unreadable(file_, layout_, column, row);
  }

 private:
  const TiffFile& file_;
  Layout layout_;
};

/// Tiles by OpenImageIO. One that it cannot read goes to libtiff, which has fewer doubts about odd
/// byte counts and says more plainly what is wrong.
class OpenImageIoTiles : public BlockReader {
 public:
  OpenImageIoTiles(const TiffFile& file, const Layout& layout,
                   std::unique_ptr<OIIO::ImageInput> input)
      : layout_(layout), input_(std::move(input)), fallback_(file, layout) {}

  void read(std::int64_t column, std::int64_t row, std::span<std::byte> out) override {
    const auto x = static_cast<int>(column * layout_.block_width);
    const auto y = static_cast<int>(row * layout_.block_height);
    const bool good = input_->read_native_tile(0, 0, x, y, 0, out.data());
    const auto message = input_->geterror();
    if (!good || !message.empty()) fallback_.read(column, row, out);
  }

 private:
  Layout layout_;
  std::unique_ptr<OIIO::ImageInput> input_;
  TiffBlocks fallback_;
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
    default:
      return OIIO::TypeDesc::UNKNOWN;
  }
}

// Layouts that OpenImageIO 2.4.7 was seen to read as libtiff does, sample by sample. Not among
// them:
// strips (its read_native_scanlines says all is well where a strip could not be decoded, and going
// back to an earlier strip of one row it decodes the file from its start); float64 (what it read
// never leaves its scratch memory); white-is-zero (it inverts the samples); codecs and integers of
// 32 or 64 bits that were not compared.
bool faithful(const Layout& layout) {
  constexpr std::uint16_t compared[] = {COMPRESSION_NONE,    COMPRESSION_LZW,
                                        COMPRESSION_DEFLATE, COMPRESSION_ADOBE_DEFLATE,
                                        COMPRESSION_ZSTD,    COMPRESSION_PACKBITS};
  return layout.tiled && layout.photometric == PHOTOMETRIC_MINISBLACK &&
         type_of(layout.sample) != OIIO::TypeDesc::UNKNOWN &&
         std::find(std::begin(compared), std::end(compared), layout.compression) !=
             std::end(compared);
}

}  // namespace

std::unique_ptr<BlockReader> block_reader(const TiffFile& file, const Layout& layout) {
  if (faithful(layout)) {
    // Its pool of threads would have nothing to do but be there.
    [[maybe_unused]] static const bool single = OIIO::attribute("threads", 1);
    auto input = OIIO::ImageInput::create("tiff");
    OIIO::ImageSpec spec;
    const OIIO::ImageSpec wish;
    // A file with a page offset (XPOSITION) numbers its pixels from there: libtiff's job then.
    if (input && input->open(file.path().string(), spec, wish) && spec.width == layout.width &&
        spec.height == layout.height && spec.nchannels == 1 && spec.x == 0 && spec.y == 0 &&
        spec.format == type_of(layout.sample) && spec.tile_width == layout.block_width &&
        spec.tile_height == layout.block_height) {
      return std::make_unique<OpenImageIoTiles>(file, layout, std::move(input));
    }
    if (input) static_cast<void>(input->geterror());
  }
  return std::make_unique<TiffBlocks>(file, layout);
}

bool has_block(const TiffFile& file, const Layout& layout, std::int64_t column, std::int64_t row) {
  return TIFFGetStrileByteCount(file.get(), block_index(layout, column, row)) != 0;
}

}  // namespace hoodoo::dem
