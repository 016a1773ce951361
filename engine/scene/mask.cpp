#include "engine/scene/mask.hpp"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string_view>
#include <vector>

namespace hoodoo::scene {
namespace {

/// The reader for a file, by its first bytes; "" for none. A name's ending would let the file
/// choose among all the formats that OpenImageIO knows.
std::string format_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::array<char, 4> head{};
  stream.read(head.data(), head.size());
  const std::string_view magic(head.data(), head.size());
  if (magic == "\x89PNG") return "png";
  using namespace std::string_view_literals;
  if (magic == "II*\0"sv || magic == "MM\0*"sv) return "tiff";
  return "";
}

/// Rows of samples from the north to weights from the south.
template <class Sample>
bool read_weights(OIIO::ImageInput& image, tree::Mask& mask) {
  const auto width = static_cast<std::size_t>(mask.width);
  const auto height = static_cast<std::size_t>(mask.height);
  constexpr auto white = static_cast<float>(std::numeric_limits<Sample>::max());
  const auto type = OIIO::TypeDesc(OIIO::BaseTypeFromC<Sample>::value);
  std::vector<Sample> pixels(width * height);
  if (!image.read_image(0, 0, 0, 1, type, pixels.data())) return false;
  mask.weights.resize(width * height);
  for (std::size_t j = 0; j < height; ++j) {
    for (std::size_t i = 0; i < width; ++i) {
      mask.weights[j * width + i] =
          static_cast<float>(pixels[(height - 1 - j) * width + i]) / white;
    }
  }
  return true;
}

}  // namespace

std::optional<tree::Mask> read_mask(const std::filesystem::path& file, const std::string& name,
                                    const std::string& where, std::size_t& pixels_left,
                                    Findings& findings) {
  const auto refuse = [&](const std::string& why) {
    findings.problems.push_back({where, fmt::format("\"{}\" {}", name, why)});
    return std::nullopt;
  };
  const auto format = format_of(file);
  if (format.empty()) return refuse("is neither PNG nor TIFF");
  const auto image = OIIO::ImageInput::create(format);
  OIIO::ImageSpec spec, wanted;
  wanted.attribute("oiio:UnassociatedAlpha", 1);  // the samples as stored
  if (!image || !image->open(file.string(), spec, wanted)) return refuse("cannot be read");
  const bool bytes = spec.format == OIIO::TypeDesc::UINT8;
  if ((!bytes && spec.format != OIIO::TypeDesc::UINT16) || spec.nchannels < 1 || spec.depth > 1) {
    return refuse("must have 8 or 16 bits per channel");
  }
  if (spec.width < 1 || spec.height < 1) return refuse("is empty");
  if (spec.nchannels > 16 || spec.tile_width > 8192 || spec.tile_height > 8192) {
    return refuse("has a layout that is not supported");
  }
  const auto pixels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  if (pixels > pixels_left) {
    findings.limits.push_back(
        {where, fmt::format("\"{}\" has {} x {} pixels; the masks of a scene may have {} more",
                            name, spec.width, spec.height, pixels_left)});
    return std::nullopt;
  }
  pixels_left -= pixels;
  tree::Mask mask;
  mask.width = spec.width;
  mask.height = spec.height;
  if (!(bytes ? read_weights<std::uint8_t>(*image, mask)
              : read_weights<std::uint16_t>(*image, mask))) {
    return refuse("cannot be read");
  }
  return mask;
}

}  // namespace hoodoo::scene
