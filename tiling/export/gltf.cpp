#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "tiling/export/formats.hpp"
#include "tiling/export/weld.hpp"

namespace hoodoo::exporting {
namespace {

namespace fs = std::filesystem;

/// A mesh may have points as far as this from its origin [steps]: floats hold 24 bits.
constexpr double most_steps = 1 << std::numeric_limits<float>::digits;
constexpr std::uint64_t most_bytes = std::uint64_t{4000}
                                     << 20;  // of a GLB, whose lengths are 32 bits
constexpr std::uint64_t vertex_bytes = 32, triangle_bytes = 12;

Error too_large(const fs::path& file, const std::string& why) {
  return {Fault::limit, file.string(), why + "; choose a --region or a coarser --level"};
}

/// Gathers all pieces into one content around the middle of their box.
class Gltf {
 public:
  Gltf(const Selection& selection, const fs::path& file) : file_(file) {
    content_.step = selection.step();
    content_.materials = selection.bake().materials;
    const Box box = selection.box();
    for (int a = 0; a < 3; ++a) {
      const double low = box.min[a] / content_.step, high = box.max[a] / content_.step;
      if ((high - low) / 2 + 2 > most_steps) {
        throw too_large(file,
                        fmt::format("is {:.0f} m long, but a glTF's positions hold {:.0f} m "
                                    "of this level",
                                    (high - low) * content_.step, 2 * most_steps * content_.step));
      }
      content_.origin[static_cast<std::size_t>(a)] =
          static_cast<std::int64_t>(std::floor((low + high) / 2));
    }
  }

  void add(const Piece& piece) {
    auto& mesh = content_.surface;
    if ((mesh.points.size() + piece.points.size()) * vertex_bytes +
            (mesh.triangles.size() + piece.triangles.size()) * triangle_bytes >
        most_bytes) {
      throw too_large(file_, "would have more than 4000 MiB, the most of a GLB");
    }
    for (const auto& p : piece.points) {
      const auto from_origin = [&](std::size_t a) {
        return static_cast<std::int32_t>(p[a] - content_.origin[a]);
      };
      mesh.points.push_back({from_origin(0), from_origin(1), from_origin(2)});
    }
    const auto append = [](auto& all, const auto& more) {
      all.insert(all.end(), more.begin(), more.end());
    };
    append(mesh.normals, piece.normals);
    append(mesh.colors, piece.colors);
    append(mesh.materials, piece.materials);
    for (const auto& [a, b, c] : piece.triangles) {
      mesh.triangles.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                                static_cast<std::uint32_t>(c)});
    }
  }

  const glb::Content& content() const { return content_; }

 private:
  fs::path file_;
  glb::Content content_;
};

/// The two chunks of a GLB as a .gltf and its buffer. glTF 2.0, section 4.4.
void write_apart(std::span<const std::byte> glb, const fs::path& file, const fs::path& buffer) {
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, glb.data() + at, sizeof value);
    return std::size_t{value};
  };
  const auto length = word(12);
  auto json = nlohmann::json::parse(
      std::string_view(reinterpret_cast<const char*>(glb.data()) + 20, length));
  auto& entry = json["buffers"][0];
  entry["uri"] = buffer.filename().string();
  const auto binary = glb.subspan(28 + length, entry["byteLength"].get<std::size_t>());
  write_file(buffer, binary);
  write_file(file, json.dump(1) + "\n");
}

}  // namespace

Report write_gltf(const Selection& selection, const fs::path& file, bool binary) {
  Gltf gltf(selection, file);
  weld(selection, true, gltf);
  const auto bytes = glb::write(gltf.content(), "plain");
  Report report;
  report.files = {file};
  report.vertices = gltf.content().surface.points.size();
  report.triangles = gltf.content().surface.triangles.size();
  if (binary) {
    write_file(file, bytes);
    return report;
  }
  auto buffer = file;
  buffer.replace_extension(".bin");
  write_apart(bytes, file, buffer);
  report.files.push_back(buffer);
  return report;
}

}  // namespace hoodoo::exporting
