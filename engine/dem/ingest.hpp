#pragma once
#include <filesystem>

#include "engine/dem/chunks.hpp"
#include "engine/dem/resample.hpp"

namespace hoodoo::dem {

/// Makes all levels of a pyramid in `folder`, which exists and is empty, and its index last.
/// The bytes depend on the recipe and the file alone, not on memory or threads.
/// Errors: io, bad_input, cancelled.
void make_pyramid(const Recipe& recipe, const Digest& digest, const std::filesystem::path& folder,
                  const IngestSettings& settings);

/// Reads the whole file once. Errors: io, not_found, cancelled.
Digest digest_of_file(const std::filesystem::path& path, const std::stop_token& stop);

}  // namespace hoodoo::dem
