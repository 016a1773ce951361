#include "tiling/glb/draco.hpp"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/base/error.hpp"

namespace hoodoo::glb {
namespace {

constexpr int normal_bits = 10;
/// One less than a float's significand: the quantiser adds a half before it rounds down.
constexpr int most_position_bits = 23;
constexpr int significand_bits = 24;

template <class Value>
int add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, draco::DataType data,
                  std::uint8_t components, bool normalized, const std::vector<Value>& values) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, components, data, normalized, sizeof(Value), 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
  mesh.attribute(id)->buffer()->Write(0, values.data(), values.size() * sizeof(Value));
  return id;
}

/// Where the grid starts, and how many bits its longest side needs.
struct Grid {
  std::array<float, 3> origin;
  int bits;
};

Grid grid_of(const Primitive& primitive, double step) {
  std::array<float, 3> low = primitive.positions.front(), high = low;
  for (const auto& p : primitive.positions) {
    for (std::size_t a = 0; a < 3; ++a) {
      if (!std::isfinite(p[a])) throw Error(Fault::internal, "", "a position is not finite");
      low[a] = std::min(low[a], p[a]);
      high[a] = std::max(high[a], p[a]);
    }
  }
  double extent = 0, reach = 0;  // [steps]
  for (std::size_t a = 0; a < 3; ++a) {
    extent = std::max(extent, (static_cast<double>(high[a]) - static_cast<double>(low[a])) / step);
    reach =
        std::max({reach, -static_cast<double>(low[a]) / step, static_cast<double>(high[a]) / step});
  }
  if (!(extent < 1 << most_position_bits && reach < 1 << significand_bits)) {
    throw Error(Fault::limit, "", "a tile is larger than 23 bits of steps");
  }
  return {low, std::max(1, static_cast<int>(std::bit_width(static_cast<std::uint32_t>(extent))))};
}

/// What ExpertEncoder::SetAttributeExplicitQuantization sets, but exact: Draco holds options as
/// text, and writes floats into it with six decimals.
draco::Options quantization(const Grid& grid, double step) {
  const double range = static_cast<double>((std::int64_t{1} << grid.bits) - 1) * step;
  draco::Options options;
  options.SetInt("quantization_bits", grid.bits);
  const auto& [x, y, z] = grid.origin;
  options.SetString("quantization_origin", fmt::format("{} {} {}", x, y, z));
  options.SetString("quantization_range", fmt::format("{}", static_cast<float>(range)));
  return options;
}

}  // namespace

Compressed compress(const Primitive& primitive, double step, bool wide_ids, int speed) {
  const Grid grid = grid_of(primitive, step);
  for (const auto& n : primitive.normals) {
    if (!(std::isfinite(n.x) && std::isfinite(n.y) && std::isfinite(n.z))) {
      throw Error(Fault::internal, "", "a normal is not finite");
    }
  }
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(primitive.positions.size()));
  mesh.SetNumFaces(primitive.triangles.size());
  for (std::size_t i = 0; i < primitive.triangles.size(); ++i) {
    const auto& t = primitive.triangles[i];
    mesh.SetFace(draco::FaceIndex(static_cast<std::uint32_t>(i)),
                 {draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  }
  using Kind = draco::GeometryAttribute;
  const int position =
      add_attribute(mesh, Kind::POSITION, draco::DT_FLOAT32, 3, false, primitive.positions);
  const int normal =
      add_attribute(mesh, Kind::NORMAL, draco::DT_FLOAT32, 3, false, primitive.normals);
  const int color = add_attribute(mesh, Kind::COLOR, draco::DT_UINT8, 4, true, primitive.colors);
  int id = 0;
  if (wide_ids) {
    id = add_attribute(mesh, Kind::GENERIC, draco::DT_UINT16, 1, false, primitive.materials);
  } else {
    const std::vector<std::uint8_t> ids(primitive.materials.begin(), primitive.materials.end());
    id = add_attribute(mesh, Kind::GENERIC, draco::DT_UINT8, 1, false, ids);
  }

  draco::ExpertEncoder encoder(mesh);
  encoder.SetSpeedOptions(speed, speed);
  encoder.options().SetAttributeOptions(position, quantization(grid, step));
  encoder.SetAttributeQuantization(normal, normal_bits);
  encoder.SetTrackEncodedProperties(true);
  draco::EncoderBuffer buffer;
  const auto status = encoder.EncodeToBuffer(&buffer);
  if (!status.ok()) {
    throw Error(Fault::internal, "", "Draco cannot encode a tile: " + status.error_msg_string());
  }
  const auto unique = [&](int attribute) {
    return static_cast<int>(mesh.attribute(attribute)->unique_id());
  };
  return {{buffer.data(), buffer.data() + buffer.size()},
          encoder.num_encoded_points(),
          encoder.num_encoded_faces(),
          {{"POSITION", unique(position)},
           {"NORMAL", unique(normal)},
           {"COLOR_0", unique(color)},
           {"_FEATURE_ID_0", unique(id)}}};
}

Primitive decompress(std::span<const std::byte> bytes, const std::map<std::string, int>& attributes,
                     const std::string& where) {
  const auto refuse = [&](const std::string& why) { return Error(Fault::bad_input, where, why); };
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  const auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    throw refuse("its Draco data cannot be decoded: " + decoded.status().error_msg_string());
  }
  const draco::Mesh& mesh = *decoded.value();
  const auto find = [&](const char* name, int components) {
    const auto at = attributes.find(name);
    const auto* attribute =
        at == attributes.end() || at->second < 0
            ? nullptr
            : mesh.GetAttributeByUniqueId(static_cast<std::uint32_t>(at->second));
    if (attribute == nullptr || attribute->num_components() != components) {
      throw refuse(std::string("its Draco data have no ") + name);
    }
    return attribute;
  };
  const auto* position = find("POSITION", 3);
  const auto* normal = find("NORMAL", 3);
  const auto* color = find("COLOR_0", 4);
  const auto* id = find("_FEATURE_ID_0", 1);
  if (position->data_type() != draco::DT_FLOAT32 || normal->data_type() != draco::DT_FLOAT32 ||
      color->data_type() != draco::DT_UINT8) {
    throw refuse("its Draco data are not of the types that were written");
  }

  Primitive primitive;
  const std::uint32_t count = mesh.num_points();
  primitive.positions.resize(count);
  primitive.normals.resize(count);
  primitive.colors.resize(count);
  primitive.materials.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const draco::PointIndex point(i);
    position->GetMappedValue(point, primitive.positions[i].data());
    normal->GetMappedValue(point, &primitive.normals[i]);
    color->GetMappedValue(point, primitive.colors[i].data());
    if (!id->ConvertValue<std::uint16_t>(id->mapped_index(point), 1, &primitive.materials[i])) {
      throw refuse("a feature id is out of range");
    }
  }
  primitive.triangles.resize(mesh.num_faces());
  for (std::uint32_t i = 0; i < mesh.num_faces(); ++i) {
    const auto& face = mesh.face(draco::FaceIndex(i));
    for (std::size_t c = 0; c < 3; ++c) {
      if (face[c].value() >= count) throw refuse("a triangle names a vertex that is not there");
      primitive.triangles[i][c] = face[c].value();
    }
  }
  return primitive;
}

}  // namespace hoodoo::glb
