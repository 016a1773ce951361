#include "tiling/glb/meshopt.hpp"

#include <meshoptimizer.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/error.hpp"

namespace hoodoo::glb {
namespace {

using nlohmann::json;

constexpr int normal_bits = 10;
constexpr std::int64_t most_steps = 1 << 23;
constexpr std::size_t most_elements = std::size_t{1} << 27;

const unsigned* first_of(const Primitive& primitive) { return primitive.triangles.data()->data(); }
std::size_t indices_of(const Primitive& primitive) { return 3 * primitive.triangles.size(); }

/// Both codecs keep their first version, which every decoder knows.
void use_first_version() {
  static const bool done = [] {
    meshopt_encodeIndexVersion(1);
    meshopt_encodeVertexVersion(0);
    return true;
  }();
  static_cast<void>(done);
}

template <class Element>
Packed pack(const std::vector<Element>& elements, const char* filter) {
  use_first_version();
  Packed packed{{}, elements.size(), sizeof(Element), "ATTRIBUTES", filter};
  packed.bytes.resize(meshopt_encodeVertexBufferBound(packed.count, packed.stride));
  packed.bytes.resize(meshopt_encodeVertexBuffer(packed.bytes.data(), packed.bytes.size(),
                                                 elements.data(), packed.count, packed.stride));
  return packed;
}

template <class Element>
void move_to(std::vector<Element>& elements, const std::vector<unsigned>& places) {
  if (elements.empty()) return;
  std::vector<Element> moved(elements.size());
  for (std::size_t i = 0; i < places.size(); ++i) moved[places[i]] = elements[i];
  elements = std::move(moved);
}

}  // namespace

Primitive reordered(const Primitive& primitive) {
  Primitive out = primitive;
  const std::size_t vertices = primitive.positions.size();
  auto* indices = out.triangles.data()->data();
  meshopt_optimizeVertexCache(indices, first_of(primitive), indices_of(primitive), vertices);
  std::vector<unsigned> places(vertices);
  const std::size_t used =
      meshopt_optimizeVertexFetchRemap(places.data(), indices, indices_of(out), vertices);
  if (used != vertices) throw Error(Fault::internal, "", "a tile has a vertex without a triangle");
  for (auto& triangle : out.triangles) {
    for (auto& vertex : triangle) vertex = places[vertex];
  }
  move_to(out.positions, places);
  move_to(out.normals, places);
  move_to(out.colors, places);
  move_to(out.materials, places);
  return out;
}

Packed pack_positions(const Primitive& primitive, double step) {
  int exponent = 0;
  std::frexp(step, &exponent);  // step = 2^(exponent - 1)
  std::vector<std::array<std::uint32_t, 3>> words;
  words.reserve(primitive.positions.size());
  for (const auto& p : primitive.positions) {
    std::array<std::uint32_t, 3> word{};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto steps = static_cast<std::int64_t>(static_cast<double>(p[a]) / step);
      if (steps < -most_steps || steps >= most_steps) {
        throw Error(Fault::limit, "", "a tile is larger than 23 bits of steps");
      }
      word[a] = static_cast<std::uint32_t>(exponent - 1) << 24 |
                (static_cast<std::uint32_t>(steps) & 0xffffffU);
    }
    words.push_back(word);
  }
  return pack(words, "EXPONENTIAL");
}

Packed pack_normals(const Primitive& primitive) {
  std::vector<std::array<float, 4>> normals;
  normals.reserve(primitive.normals.size());
  for (const auto& n : primitive.normals) normals.push_back({n.x, n.y, n.z, 0});
  std::vector<std::array<std::int16_t, 4>> words(normals.size());
  meshopt_encodeFilterOct(words.data(), words.size(), sizeof words[0], normal_bits,
                          normals.data()->data());
  return pack(words, "OCTAHEDRAL");
}

Packed pack_colors(const Primitive& primitive) { return pack(primitive.colors, "NONE"); }

Packed pack_materials(const Primitive& primitive) {
  return pack(std::vector<std::uint32_t>(primitive.materials.begin(), primitive.materials.end()),
              "NONE");
}

Packed pack_triangles(const Primitive& primitive) {
  use_first_version();
  const std::size_t count = indices_of(primitive);
  Packed packed{{}, count, sizeof(std::uint32_t), "TRIANGLES", "NONE"};
  packed.bytes.resize(meshopt_encodeIndexBufferBound(count, primitive.positions.size()));
  packed.bytes.resize(meshopt_encodeIndexBuffer(packed.bytes.data(), packed.bytes.size(),
                                                first_of(primitive), count));
  return packed;
}

json packed_view(const json& view, const Packed& packed, std::size_t offset) {
  json stand{{"buffer", 1},
             {"byteOffset", offset},
             {"byteLength", packed.count * packed.stride},
             {"extensions",
              {{"EXT_meshopt_compression",
                {{"buffer", 0},
                 {"byteOffset", view.value("byteOffset", 0)},
                 {"byteLength", view.at("byteLength")},
                 {"byteStride", packed.stride},
                 {"count", packed.count},
                 {"mode", packed.mode},
                 {"filter", packed.filter}}}}}};
  if (packed.mode == "ATTRIBUTES") stand["byteStride"] = packed.stride;
  stand["target"] = packed.mode == "ATTRIBUTES" ? 34962 : 34963;
  return stand;
}

std::vector<std::byte> unpack(std::span<const std::byte> bytes, const json& extension,
                              const std::string& where) {
  const auto refuse = [&](const char* why) { return Error(Fault::bad_input, where, why); };
  const auto count = extension.at("count").get<std::size_t>();
  const auto stride = extension.at("byteStride").get<std::size_t>();
  const auto mode = extension.at("mode").get<std::string>();
  const auto filter = extension.value("filter", "NONE");
  // A byte of the streams stands for so many elements at most, which bounds what may be claimed.
  if (count > most_elements || count > 64 * bytes.size() + 64) {
    throw refuse("claims more elements than its bytes can hold");
  }
  const auto* from = reinterpret_cast<const unsigned char*>(bytes.data());
  std::vector<std::byte> out;
  if (mode == "ATTRIBUTES") {
    if (stride == 0 || stride > 256 || stride % 4 != 0) throw refuse("has a stride that cannot be");
    out.resize(count * stride);
    if (meshopt_decodeVertexBuffer(out.data(), count, stride, from, bytes.size()) != 0) {
      throw refuse("has vertices that cannot be decoded");
    }
  } else if (mode == "TRIANGLES") {
    if (stride != 4 || count % 3 != 0) throw refuse("has indices of another size");
    out.resize(count * stride);
    if (meshopt_decodeIndexBuffer(out.data(), count, stride, from, bytes.size()) != 0) {
      throw refuse("has triangles that cannot be decoded");
    }
  } else {
    throw refuse("has a mode of compression that is not known");
  }
  if (filter == "EXPONENTIAL") {
    meshopt_decodeFilterExp(out.data(), count, stride);
  } else if (filter == "OCTAHEDRAL") {
    if (stride != 8) throw refuse("has normals of another size");
    meshopt_decodeFilterOct(out.data(), count, stride);
  } else if (filter != "NONE") {
    throw refuse("has a filter that is not known");
  }
  return out;
}

}  // namespace hoodoo::glb
