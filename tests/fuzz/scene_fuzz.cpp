// Any bytes as the text of a scene: refused with problems, or found good; never anything else.
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/base/error.hpp"
#include "engine/base/json.hpp"
#include "engine/scene/sample.hpp"
#include "engine/scene/scene.hpp"

using namespace hoodoo;
namespace fs = std::filesystem;

namespace {

/// A folder with "dem.tif", so that a scene gets past its terrains.
class Sources {
 public:
  Sources() : folder_(fs::temp_directory_path() / ("hoodoo-fuzz-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    scene::write_sample_dem(folder_ / "dem.tif", {16, 8, 1});
  }
  ~Sources() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Sources(const Sources&) = delete;
  Sources& operator=(const Sources&) = delete;
  scene::Sources sources() const { return {folder_, {folder_}}; }

 private:
  fs::path folder_;
};

}  // namespace

// libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Sources files;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const auto scene = parse_json(text, "scene");
    for (const auto& problem : scene::check(scene, files.sources())) {
      if (problem.what.empty()) std::abort();
    }
  } catch (const Error& error) {
    if (error.fault == Fault::internal || error.fault == Fault::io) throw;
  }
  return 0;
}
