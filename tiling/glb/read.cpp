#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <deque>
#include <nlohmann/json.hpp>
#include <span>

#include "engine/base/error.hpp"
#include "engine/base/json.hpp"
#include "tiling/glb/draco.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/glb/meshopt.hpp"

namespace hoodoo::glb {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF is little-endian");

using nlohmann::json;
using Bytes = std::span<const std::byte>;

/// A file split in its chunks, with checked access to what the JSON names.
/// tinygltf trusts the indices it finds, so it does not read what may come from anywhere.
class File {
 public:
  File(Bytes bytes, std::string where) : where_(std::move(where)) {
    constexpr std::uint32_t magic = 0x46546C67, json_chunk = 0x4E4F534A, binary_chunk = 0x004E4942;
    if (bytes.size() < 12 || word(bytes, 0) != magic) throw refuse("is not a binary glTF file");
    if (word(bytes, 4) != 2) throw refuse("is not glTF 2.0");
    if (word(bytes, 8) != bytes.size()) throw refuse("is cut short");
    Bytes rest = bytes.subspan(12);
    const auto chunk = [&](std::uint32_t kind) {
      if (rest.size() < 8 || word(rest, 0) > rest.size() - 8) throw refuse("is cut short");
      if (word(rest, 4) != kind) throw refuse("has an unexpected chunk");
      const Bytes body = rest.subspan(8, word(rest, 0));
      rest = rest.subspan(8 + body.size());
      return body;
    };
    const Bytes text = chunk(json_chunk);
    const JsonLimits limits{.bytes = 16U << 20, .depth = 32, .values = 1'000'000};
    json_ = parse_json({reinterpret_cast<const char*>(text.data()), text.size()}, where_, limits);
    binary_ = chunk(binary_chunk);
  }

  const json& root() const { return json_; }
  const std::string& where() const { return where_; }
  Error refuse(const std::string& why) const { return {Fault::bad_input, where_, why}; }

  /// A whole number that is not negative.
  std::size_t natural(const json& value) const {
    if (!value.is_number_unsigned()) throw refuse("has " + value.dump() + " where a count belongs");
    return value.get<std::size_t>();
  }
  Bytes view(const json& index) const {
    const json& entry = json_.at("bufferViews").at(natural(index));
    const json extensions = entry.value("extensions", json::object());
    if (!extensions.contains("EXT_meshopt_compression")) return stored(entry);
    const json& packed = extensions.at("EXT_meshopt_compression");
    unpacked_.push_back(unpack(stored(packed), packed, where_));
    return unpacked_.back();
  }
  const json& accessor(const json& index) const { return json_.at("accessors").at(natural(index)); }

  /// The elements of an accessor of `component` type, `Value` bytes each, `stride` apart.
  template <class Value>
  std::vector<Value> elements(const json& index, int component, std::size_t stride) const {
    const json& entry = accessor(index);
    if (entry.at("componentType") != component) throw refuse("has an accessor of another type");
    const Bytes bytes = view(entry.at("bufferView"));
    const auto count = natural(entry.at("count"));
    if (count > bytes.size() / stride) throw refuse("has an accessor that leaves its buffer view");
    std::vector<Value> values(count);
    for (std::size_t i = 0; i < count; ++i) {
      std::memcpy(&values[i], bytes.data() + i * stride, sizeof(Value));
    }
    return values;
  }

 private:
  /// Bytes that `entry` names by offset and length.
  Bytes stored(const json& entry) const {
    const auto offset = entry.contains("byteOffset") ? natural(entry.at("byteOffset")) : 0;
    const auto size = natural(entry.at("byteLength"));
    if (offset > binary_.size() || size > binary_.size() - offset) {
      throw refuse("has a buffer view that leaves its buffer");
    }
    return binary_.subspan(offset, size);
  }
  static std::uint32_t word(Bytes bytes, std::size_t at) {
    std::uint32_t value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
  }

  std::string where_;
  json json_;
  Bytes binary_;
  mutable std::deque<std::vector<std::byte>> unpacked_;  // what views hold that are packed
};

constexpr int type_u8 = 5121, type_i16 = 5122, type_u16 = 5123, type_u32 = 5125, type_float = 5126;

/// Of floats, or of shorts that stand for parts of 32767 [glTF 2.0, 3.11].
std::vector<Vec3f> read_normals(const File& file, const json& index) {
  if (file.accessor(index).at("componentType") != type_i16) {
    return file.elements<Vec3f>(index, type_float, 12);
  }
  std::vector<Vec3f> normals;
  for (const auto& v : file.elements<std::array<std::int16_t, 3>>(index, type_i16, 8)) {
    const auto part = [](std::int16_t c) { return std::max(-1.0, c / 32767.0); };
    const Vec3 n = normalized({part(v[0]), part(v[1]), part(v[2])});
    normals.push_back({static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)});
  }
  return normals;
}

Primitive read_plain(const File& file, const json& source) {
  Primitive primitive;
  const json& attributes = source.at("attributes");
  primitive.positions =
      file.elements<std::array<float, 3>>(attributes.at("POSITION"), type_float, 12);
  primitive.normals = read_normals(file, attributes.at("NORMAL"));
  primitive.colors =
      file.elements<std::array<std::uint8_t, 4>>(attributes.at("COLOR_0"), type_u8, 4);
  const auto indices = file.elements<std::uint32_t>(source.at("indices"), type_u32, 4);
  primitive.triangles.resize(indices.size() / 3);
  for (std::size_t i = 0; i < primitive.triangles.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) primitive.triangles[i][c] = indices[3 * i + c];
  }
  const json& ids = attributes.at("_FEATURE_ID_0");
  if (file.accessor(ids).at("componentType") == type_u16) {
    primitive.materials = file.elements<std::uint16_t>(ids, type_u16, 4);
  } else {
    const auto narrow = file.elements<std::uint8_t>(ids, type_u8, 4);
    primitive.materials.assign(narrow.begin(), narrow.end());
  }
  return primitive;
}

Primitive read_primitive(const File& file, const json& source) {
  const json& attributes = source.at("attributes");
  const auto vertices = file.natural(file.accessor(attributes.at("POSITION")).at("count"));
  const auto indices = file.natural(file.accessor(source.at("indices")).at("count"));
  Primitive primitive;
  const json extensions = source.value("extensions", json::object());
  if (extensions.contains("KHR_draco_mesh_compression")) {
    const json& draco = extensions.at("KHR_draco_mesh_compression");
    std::map<std::string, int> ids;
    for (const auto& [name, id] : draco.at("attributes").items()) {
      ids[name] = static_cast<int>(file.natural(id) & 0xFFFF);
    }
    primitive = decompress(file.view(draco.at("bufferView")), ids, file.where());
  } else {
    primitive = read_plain(file, source);
  }
  if (primitive.positions.size() != vertices || primitive.normals.size() != vertices ||
      primitive.colors.size() != vertices || primitive.materials.size() != vertices ||
      primitive.triangles.size() * 3 != indices) {
    throw file.refuse("holds another number of vertices or triangles than it says");
  }
  for (const auto& triangle : primitive.triangles) {
    for (const auto vertex : triangle) {
      if (vertex >= vertices) throw file.refuse("a triangle names a vertex that is not there");
    }
  }
  return primitive;
}

/// `metres` as a whole number of steps below `most`.
std::int64_t steps_of(const File& file, double metres, double step, double most) {
  const double steps = metres / step;
  if (!(std::abs(steps) < most) || std::nearbyint(steps) != steps) {
    throw file.refuse("has a position that is not a multiple of its step");
  }
  return static_cast<std::int64_t>(steps);
}

Decoded::Part to_part(const File& file, Primitive primitive, double step) {
  Decoded::Part part;
  part.points.reserve(primitive.positions.size());
  for (const auto& p : primitive.positions) {
    const auto steps = [&](float metres) {
      return static_cast<std::int32_t>(steps_of(file, static_cast<double>(metres), step, 1 << 24));
    };
    part.points.push_back({steps(p[0]), -steps(p[2]), steps(p[1])});
  }
  part.normals = std::move(primitive.normals);
  for (auto& n : part.normals) n = {n.x, -n.z, n.y};
  part.colors = std::move(primitive.colors);
  part.materials = std::move(primitive.materials);
  part.triangles = std::move(primitive.triangles);
  return part;
}

Decoded decode(const File& file, double step, Wanted wanted) {
  Decoded decoded;
  if (step == 0) {
    step = file.root().at("asset").at("extras").at("hoodoo").at("step").get<double>();
    if (!(step > 0 && std::isfinite(step))) throw file.refuse("has a step that cannot be");
  }
  decoded.step = step;
  const json& node = file.root().at("nodes").at(0);
  if (node.contains("translation")) {
    const auto steps = [&](std::size_t axis) {
      const json& metres = node.at("translation").at(axis);
      return steps_of(file, metres.get<double>(), step, 9007199254740992.0);
    };
    decoded.origin = {steps(0), -steps(2), steps(1)};
  }
  const json& primitives = file.root().at("meshes").at(0).at("primitives");
  for (const json& source : primitives) {
    const json extras = source.value("extras", json::object());
    const json mark = extras.is_object() ? extras.value("hoodoo", json::object()) : json::object();
    const bool skirt = mark.is_object() && mark.value("role", "") == "skirt";
    if (skirt && wanted == Wanted::surface) continue;
    auto& part = skirt ? decoded.skirt : decoded.surface;
    if (!part.triangles.empty()) throw file.refuse("has more primitives than a tile");
    part = to_part(file, read_primitive(file, source), step);
  }
  return decoded;
}

}  // namespace

Decoded read(const std::vector<std::byte>& bytes, double step, const std::string& where,
             Wanted wanted) {
  const File file(bytes, where);
  try {
    return decode(file, step, wanted);
  } catch (const json::exception& error) {
    throw file.refuse(std::string("is not a tile of hoodoo: ") + error.what());
  }
}

}  // namespace hoodoo::glb
