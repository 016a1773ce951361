#pragma once
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "engine/base/error.hpp"

namespace hoodoo {

/// A folder that is removed again. Errors: io.
struct TemporaryFolder {
  std::filesystem::path path;

  TemporaryFolder() {
    auto name = (std::filesystem::temp_directory_path() / "hoodoo-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw Error(Fault::io, name, "cannot be made");
    path = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
};

}  // namespace hoodoo
