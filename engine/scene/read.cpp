#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "engine/scene/scene.hpp"

namespace hoodoo::scene {

nlohmann::json read(const std::filesystem::path& file) {
  const JsonLimits limits;
  return parse_json(read_file(file, limits.bytes), file.string(), limits);
}

}  // namespace hoodoo::scene
