#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdio>
#include <limits>
#include <memory>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/base/file_writer.hpp"
#include "engine/base/math.hpp"
#include "tiling/export/formats.hpp"
#include "tiling/export/weld.hpp"

namespace hoodoo::exporting {
namespace {

namespace fs = std::filesystem;
static_assert(std::endian::native == std::endian::little, "the PLY says that it is");

/// sRGB of each linear level, both in 8 bits. IEC 61966-2-1.
const std::array<std::uint8_t, 256>& srgb_of_linear() {
  static const auto table = [] {
    std::array<std::uint8_t, 256> t{};
    for (std::size_t i = 0; i < t.size(); ++i) {
      const double v = static_cast<double>(i) / 255;
      const double s = v <= 0.0031308 ? 12.92 * v : 1.055 * bit_pow(v, 1 / 2.4) - 0.055;
      t[i] = static_cast<std::uint8_t>(255 * s + 0.5);
    }
    return t;
  }();
  return table;
}

/// Bytes that wait in a nameless file beside another one.
class Waiting {
 public:
  explicit Waiting(const fs::path& beside) : path_(beside) {
    path_ += ".faces";
    path_ += leftover_suffix;
    file_.reset(std::fopen(path_.c_str(), "w+b"));
    if (!file_) fail();
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  template <class Record>
  void put(const std::vector<Record>& records) {
    if (std::fwrite(records.data(), sizeof(Record), records.size(), file_.get()) !=
        records.size()) {
      fail();
    }
  }
  void copy_to(FileWriter& target) {
    std::rewind(file_.get());
    std::vector<std::byte> buffer(std::size_t{1} << 20);
    for (;;) {
      const auto got = std::fread(buffer.data(), 1, buffer.size(), file_.get());
      target.write(std::span(buffer).first(got));
      if (got == buffer.size()) continue;
      if (std::ferror(file_.get()) != 0) fail();
      return;
    }
  }

 private:
  [[noreturn]] void fail() const {
    throw Error(Fault::io, path_.string(), "cannot be written: a temporary file");
  }
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  fs::path path_;
  std::unique_ptr<std::FILE, Close> file_;
};

#pragma pack(push, 1)
struct Vertex {
  std::array<double, 3> position;
  std::array<float, 3> normal;
  std::array<std::uint8_t, 3> color;
};
struct Face {
  std::uint8_t corners = 3;
  std::array<std::int32_t, 3> vertices;
  std::uint16_t material;
};
#pragma pack(pop)

class Ply {
 public:
  Ply(const Selection& selection, const fs::path& file)
      : selection_(selection), path_(file), file_(file), faces_(file) {
    file_.write(header());
  }

  void add(const Piece& piece) {
    if (vertices_ + piece.points.size() > std::numeric_limits<std::int32_t>::max()) {
      throw Error(Fault::limit, path_.string(),
                  "would have more than 2147483647 vertices, the most of a PLY; choose a --region "
                  "or a coarser --level");
    }
    std::vector<Vertex> vertices;
    vertices.reserve(piece.points.size());
    for (std::size_t i = 0; i < piece.points.size(); ++i) {
      const auto at = [&](std::size_t a) {
        return static_cast<double>(piece.points[i][a]) * selection_.step();
      };
      const auto& n = piece.normals[i];
      const auto& c = piece.colors[i];
      const auto& srgb = srgb_of_linear();
      vertices.push_back(
          {{at(0), at(1), at(2)}, {n.x, n.y, n.z}, {srgb[c[0]], srgb[c[1]], srgb[c[2]]}});
    }
    std::vector<Face> faces;
    faces.reserve(piece.triangles.size());
    for (std::size_t i = 0; i < piece.triangles.size(); ++i) {
      const auto corner = [&](std::size_t c) {
        return static_cast<std::int32_t>(piece.triangles[i][c]);
      };
      faces.push_back({.vertices = {corner(0), corner(1), corner(2)}, .material = piece.faces[i]});
    }
    file_.write(std::as_bytes(std::span(vertices)));
    faces_.put(faces);
    vertices_ += vertices.size();
    triangles_ += faces.size();
  }

  void finish(Report& report) {
    faces_.copy_to(file_);
    file_.seek(0);
    file_.write(header());
    file_.commit();
    report.vertices = vertices_;
    report.triangles = triangles_;
  }

 private:
  /// As long before the counts are known as after: a comment makes up for their digits.
  std::string header() const {
    const auto vertices = fmt::format("{}", vertices_), triangles = fmt::format("{}", triangles_);
    auto text = fmt::format("ply\nformat binary_little_endian 1.0\ncomment {:.<{}}\n", "",
                            42 - vertices.size() - triangles.size());
    text += fmt::format("comment hoodoo {}: level {}, metres, z up\n", selection_.bake().engine,
                        selection_.level());
    const auto& materials = selection_.bake().materials;
    for (std::size_t i = 0; i < materials.size(); ++i) {
      const auto& [r, g, b] = materials[i].color;
      auto name = materials[i].name;
      for (char& c : name) {
        if (static_cast<unsigned char>(c) < ' ') c = ' ';  // a line ends a comment
      }
      text += fmt::format("comment material {} #{:02x}{:02x}{:02x} {}\n", i, r, g, b, name);
    }
    text += "element vertex " + vertices + "\n";
    for (const char* axis : {"x", "y", "z"}) text += fmt::format("property double {}\n", axis);
    for (const char* axis : {"x", "y", "z"}) text += fmt::format("property float n{}\n", axis);
    for (const char* color : {"red", "green", "blue"}) {
      text += fmt::format("property uchar {}\n", color);
    }
    text += "element face " + triangles + "\n";
    return text + "property list uchar int vertex_indices\nproperty ushort material\nend_header\n";
  }

  const Selection& selection_;
  fs::path path_;
  FileWriter file_;
  Waiting faces_;
  std::uint64_t vertices_ = 0, triangles_ = 0;
};

}  // namespace

Report write_ply(const Selection& selection, const fs::path& file) {
  Ply ply(selection, file);
  weld(selection, false, ply);
  Report report;
  report.files = {file};
  ply.finish(report);
  return report;
}

}  // namespace hoodoo::exporting
