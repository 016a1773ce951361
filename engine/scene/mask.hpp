#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "engine/scene/files.hpp"
#include "engine/tree/region.hpp"

namespace hoodoo::scene {

/// Reads the weights of a painted mask: a PNG or TIFF of 8 or 16 bits per channel, black 0, white
/// 1, the first channel only. Its place is the caller's to set. `pixels_left` is lowered by its
/// size; an image that is larger is a limit, found before its pixels are read.
/// Problems stand at `where` and call the file `name`.
std::optional<tree::Mask> read_mask(const std::filesystem::path& file, const std::string& name,
                                    const std::string& where, std::size_t& pixels_left,
                                    Findings& findings);

}  // namespace hoodoo::scene
