#include <algorithm>
#include <cassert>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>
#include <utility>

#include "engine/base/error.hpp"
#include "tiling/glb/draco.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/glb/meshopt.hpp"
#include "tiling/glb/metadata.hpp"
#include "tiling/slice/slice.hpp"

namespace hoodoo::glb {
namespace {

constexpr const char* draco_extension = "KHR_draco_mesh_compression";
constexpr const char* meshopt_extension = "EXT_meshopt_compression";

/// z up to y up: (x, y, z) -> (x, z, -y).
Primitive to_gltf(const surface::Mesh& mesh, double step) {
  Primitive primitive;
  primitive.positions.reserve(mesh.points.size());
  primitive.normals.reserve(mesh.points.size());
  const auto metres = [&](std::int64_t steps) {
    if (std::abs(steps) >= 1 << std::numeric_limits<float>::digits) {
      throw Error(Fault::limit, "", "a tile is larger than 24 bits of steps");
    }
    return static_cast<float>(static_cast<double>(steps) * step);
  };
  for (const auto& p : mesh.points) {
    primitive.positions.push_back({metres(p[0]), metres(p[2]), metres(-std::int64_t{p[1]})});
  }
  for (const auto& n : mesh.normals) primitive.normals.push_back({n.x, n.z, -n.y});
  primitive.colors = mesh.colors;
  primitive.materials = mesh.materials;
  primitive.triangles = mesh.triangles;
  return primitive;
}

/// Lowest and highest corner of the vertices that the triangles use.
void set_bounds(tinygltf::Accessor& accessor, const Primitive& primitive) {
  accessor.minValues.assign(3, std::numeric_limits<double>::infinity());
  accessor.maxValues.assign(3, -std::numeric_limits<double>::infinity());
  for (const auto& triangle : primitive.triangles) {
    for (const auto vertex : triangle) {
      for (std::size_t a = 0; a < 3; ++a) {
        const double value = static_cast<double>(primitive.positions[vertex][a]);
        accessor.minValues[a] = std::min(accessor.minValues[a], value);
        accessor.maxValues[a] = std::max(accessor.maxValues[a], value);
      }
    }
  }
}

/// Builds one file's model, primitive by primitive.
class Builder {
 public:
  Builder(double step, bool wide_ids) : step_(step), wide_ids_(wide_ids) {
    model_.asset.version = "2.0";
    model_.asset.generator = "hoodoo " + std::string(slice::engine_version());
    model_.asset.extras = to_value({{"hoodoo", {{"step", step}}}});
    model_.buffers.emplace_back();
    tinygltf::Material material;
    material.name = "terrain";
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.roughnessFactor = 1;
    model_.materials.push_back(material);
    model_.extensionsUsed.emplace_back("EXT_mesh_features");
  }

  tinygltf::Model& model() { return model_; }

  void require(std::initializer_list<const char*> extensions) {
    for (const char* name : extensions) {
      model_.extensionsUsed.emplace_back(name);
      model_.extensionsRequired.emplace_back(name);
    }
  }

  void add_draco(const Primitive& primitive, int speed) {
    const Compressed compressed = compress(primitive, step_, wide_ids_, speed);
    const int view = add_view(model_, std::as_bytes(std::span(compressed.bytes)));
    auto result = accessors(primitive, compressed.vertices, compressed.triangles);
    result.extensions[draco_extension] =
        to_value({{"bufferView", view}, {"attributes", compressed.attributes}});
    finish(std::move(result), primitive);
  }

  void add_plain(const Primitive& primitive) {
    auto result = accessors(primitive, primitive.positions.size(), primitive.triangles.size());
    const auto put = [&](int accessor, std::span<const std::byte> bytes, int target) {
      const int view = add_view(model_, bytes);
      model_.bufferViews[static_cast<std::size_t>(view)].target = target;
      model_.accessors[static_cast<std::size_t>(accessor)].bufferView = view;
      return view;
    };
    const auto vertices = [&](const char* name, const auto& values) {
      put(result.attributes[name], std::as_bytes(std::span(values)), TINYGLTF_TARGET_ARRAY_BUFFER);
    };
    put(result.indices, std::as_bytes(std::span(primitive.triangles)),
        TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    vertices("POSITION", primitive.positions);
    vertices("NORMAL", primitive.normals);
    vertices("COLOR_0", primitive.colors);
    // Elements of a vertex attribute start at multiples of four bytes (glTF 2.0, 3.6.2.4). In
    // little-endian order a wide id's low byte or two stand where a narrow one's do.
    const std::vector<std::uint32_t> ids(primitive.materials.begin(), primitive.materials.end());
    const int view = put(result.attributes["_FEATURE_ID_0"], std::as_bytes(std::span(ids)),
                         TINYGLTF_TARGET_ARRAY_BUFFER);
    model_.bufferViews[static_cast<std::size_t>(view)].byteStride = sizeof(std::uint32_t);
    finish(std::move(result), primitive);
  }

  void add_meshopt(const Primitive& given) {
    const Primitive primitive = reordered(given);
    auto result = accessors(primitive, primitive.positions.size(), primitive.triangles.size());
    auto& normals = model_.accessors[static_cast<std::size_t>(result.attributes["NORMAL"])];
    normals.componentType = TINYGLTF_COMPONENT_TYPE_SHORT;
    normals.normalized = true;
    const auto put = [&](int accessor, Packed packed) {
      const int view = add_view(model_, std::as_bytes(std::span(packed.bytes)));
      model_.accessors[static_cast<std::size_t>(accessor)].bufferView = view;
      packed.bytes.clear();
      packed_.emplace_back(view, std::move(packed));
    };
    put(result.indices, pack_triangles(primitive));
    put(result.attributes["POSITION"], pack_positions(primitive, step_));
    put(result.attributes["NORMAL"], pack_normals(primitive));
    put(result.attributes["COLOR_0"], pack_colors(primitive));
    put(result.attributes["_FEATURE_ID_0"], pack_materials(primitive));
    finish(std::move(result), primitive);
  }

  void mark_last_as_skirt() {
    mesh_.primitives.back().extras = to_value({{"hoodoo", {{"role", "skirt"}}}});
  }

  std::vector<std::byte> file(const std::array<std::int64_t, 3>& origin) {
    mesh_.name = "terrain";
    model_.meshes.push_back(std::move(mesh_));
    tinygltf::Node node;
    node.mesh = 0;
    const auto metres = [&](std::int64_t steps) { return static_cast<double>(steps) * step_; };
    node.translation = {metres(origin[0]), metres(origin[2]), metres(-origin[1])};
    model_.nodes.push_back(std::move(node));
    tinygltf::Scene scene;
    scene.nodes = {0};
    model_.scenes.push_back(std::move(scene));
    model_.defaultScene = 0;

    std::ostringstream stream;
    tinygltf::TinyGLTF writer;
    if (!writer.WriteGltfSceneToStream(&model_, stream, false, true)) {
      throw Error(Fault::internal, "", "tinygltf cannot write a tile");
    }
    if (!packed_.empty()) return with_fallback(stream.view());
    const auto bytes = std::as_bytes(std::span(stream.view()));
    return {bytes.begin(), bytes.end()};
  }

 private:
  /// The file with its packed views as the extension describes them, which tinygltf cannot: they
  /// lie in a second buffer that has a length and no bytes.
  std::vector<std::byte> with_fallback(std::string_view file) const {
    const std::string_view binary = file.substr(20 + chunk_length(file, 12));
    auto root = nlohmann::json::parse(file.substr(20, chunk_length(file, 12)));
    std::size_t length = 0;
    for (const auto& [index, packed] : packed_) {
      auto& view = root.at("bufferViews").at(static_cast<std::size_t>(index));
      view = packed_view(view, packed, length);
      length += (packed.count * packed.stride + 3) / 4 * 4;
    }
    root.at("buffers").push_back(
        {{"byteLength", length}, {"extensions", {{meshopt_extension, {{"fallback", true}}}}}});
    std::string text = root.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string all(file.substr(0, 20));
    put_length(all, 8, 20 + text.size() + binary.size());
    put_length(all, 12, text.size());
    all.append(text).append(binary);
    const auto bytes = std::as_bytes(std::span(all));
    return {bytes.begin(), bytes.end()};
  }
  static std::size_t chunk_length(std::string_view file, std::size_t at) {
    std::uint32_t length = 0;
    std::memcpy(&length, file.data() + at, sizeof length);
    return length;
  }
  static void put_length(std::string& file, std::size_t at, std::size_t length) {
    const auto word = static_cast<std::uint32_t>(length);
    std::memcpy(file.data() + at, &word, sizeof word);
  }

  int accessor(int type, int component, std::size_t count) {
    tinygltf::Accessor result;
    result.bufferView = -1;
    result.type = type;
    result.componentType = component;
    result.count = count;
    model_.accessors.push_back(std::move(result));
    return static_cast<int>(model_.accessors.size() - 1);
  }

  tinygltf::Primitive accessors(const Primitive& primitive, std::size_t vertices,
                                std::size_t triangles) {
    tinygltf::Primitive result;
    result.mode = TINYGLTF_MODE_TRIANGLES;
    result.material = 0;
    result.indices =
        accessor(TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, 3 * triangles);
    const int position = accessor(TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT, vertices);
    set_bounds(model_.accessors[static_cast<std::size_t>(position)], primitive);
    result.attributes["POSITION"] = position;
    result.attributes["NORMAL"] =
        accessor(TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT, vertices);
    const int color = accessor(TINYGLTF_TYPE_VEC4, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, vertices);
    model_.accessors[static_cast<std::size_t>(color)].normalized = true;
    result.attributes["COLOR_0"] = color;
    result.attributes["_FEATURE_ID_0"] = accessor(
        TINYGLTF_TYPE_SCALAR,
        wide_ids_ ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE,
        vertices);
    return result;
  }

  void finish(tinygltf::Primitive result, const Primitive& primitive) {
    result.extensions["EXT_mesh_features"] = features(primitive.materials);
    mesh_.primitives.push_back(std::move(result));
  }

  double step_;
  bool wide_ids_;
  tinygltf::Model model_;
  tinygltf::Mesh mesh_;
  std::vector<std::pair<int, Packed>> packed_;  // by buffer view; without their bytes
};

}  // namespace

std::vector<std::byte> write(const Content& content, std::string_view profile) {
  assert(profile == "draco" || profile == "meshopt" || profile == "plain");
  assert(!content.surface.triangles.empty());
  Builder builder(content.step, content.materials.size() > most_short_id);
  if (profile == "draco") builder.require({draco_extension});
  if (profile == "meshopt") builder.require({meshopt_extension, "KHR_mesh_quantization"});
  const auto add = [&](const surface::Mesh& mesh) {
    const Primitive primitive = to_gltf(mesh, content.step);
    if (profile == "draco") return builder.add_draco(primitive, content.draco_speed);
    profile == "meshopt" ? builder.add_meshopt(primitive) : builder.add_plain(primitive);
  };
  add(content.surface);
  if (!content.skirt.triangles.empty()) {
    add(content.skirt);
    builder.mark_last_as_skirt();
  }
  add_materials(builder.model(), content.materials);
  return builder.file(content.origin);
}

}  // namespace hoodoo::glb
