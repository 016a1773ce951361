#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>

#include "tiling/glb/glb.hpp"

namespace hoodoo::glb {

std::uint64_t vertices_of(const std::vector<std::byte>& bytes) {
  // glTF 2.0, section 4.4: a header of 12 bytes, then the JSON chunk: its length, its type, itself.
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, sizeof length);
  const auto* text = reinterpret_cast<const char*>(bytes.data()) + 20;
  const auto gltf = nlohmann::json::parse(std::string_view(text, length));
  std::uint64_t vertices = 0;
  for (const auto& mesh : gltf["meshes"]) {
    for (const auto& primitive : mesh["primitives"]) {
      const auto accessor = primitive["attributes"]["POSITION"].get<std::size_t>();
      vertices += gltf["accessors"][accessor]["count"].get<std::uint64_t>();
    }
  }
  return vertices;
}

}  // namespace hoodoo::glb
