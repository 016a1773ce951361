#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "engine/base/file.hpp"
#include "engine/base/file_writer.hpp"
#include "tiling/export/formats.hpp"
#include "tiling/export/weld.hpp"

namespace hoodoo::exporting {
namespace {

namespace fs = std::filesystem;

/// Names for `usemtl`, which end at a space and are told apart.
std::vector<std::string> names_of(const std::vector<tree::Material>& materials) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const auto& material : materials) {
    auto name = material.name;
    for (char& c : name) {
      if (static_cast<unsigned char>(c) <= ' ' || c == '#' || c == '\\' || c == 127) c = '_';
    }
    if (name.empty()) name = "_";
    const auto plain = name;
    for (int i = 2; !taken.insert(name).second; ++i) name = fmt::format("{}_{}", plain, i);
    names.push_back(name);
  }
  return names;
}

/// The MTL: the materials' own colours, without gloss.
std::string library_of(const std::vector<tree::Material>& materials,
                       const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto level = [&](std::size_t c) { return materials[i].color[c] / 255.0; };
    text += fmt::format("newmtl {}\nKd {:.6f} {:.6f} {:.6f}\nKs 0 0 0\nillum 1\n\n", names[i],
                        level(0), level(1), level(2));
  }
  return text;
}

/// Writes each piece as it comes: a face names vertices before it, so nothing must wait.
class Obj {
 public:
  Obj(const fs::path& file, std::vector<std::string> names, double step)
      : file_(file), names_(std::move(names)), step_(step) {}

  void begin(const fs::path& library, const Selection& selection) {
    file_.write(fmt::format("# hoodoo {}: level {}, metres, z up\nmtllib {}\no terrain\n",
                            selection.bake().engine, selection.level(), library.string()));
  }

  void add(const Piece& piece) {
    fmt::memory_buffer text;
    const auto to = std::back_inserter(text);
    for (const auto& p : piece.points) {
      const auto at = [&](std::size_t a) { return static_cast<double>(p[a]) * step_; };
      fmt::format_to(to, "v {} {} {}\n", at(0), at(1), at(2));
    }
    for (const auto& n : piece.normals) {
      fmt::format_to(to, "vn {:.6f} {:.6f} {:.6f}\n", n.x, n.y, n.z);
    }
    std::map<std::uint16_t, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < piece.faces.size(); ++i) groups[piece.faces[i]].push_back(i);
    for (const auto& [material, triangles] : groups) {
      fmt::format_to(to, "usemtl {}\n", names_[material]);
      for (const auto i : triangles) {
        const auto& [a, b, c] = piece.triangles[i];
        fmt::format_to(to, "f {0}//{0} {1}//{1} {2}//{2}\n", a + 1, b + 1, c + 1);
      }
    }
    file_.write(std::string_view(text.data(), text.size()));
    vertices_ += piece.points.size();
    triangles_ += piece.triangles.size();
  }

  void finish(Report& report) {
    file_.commit();
    report.vertices = vertices_;
    report.triangles = triangles_;
  }

 private:
  FileWriter file_;
  std::vector<std::string> names_;
  double step_;
  std::uint64_t vertices_ = 0, triangles_ = 0;
};

}  // namespace

Report write_obj(const Selection& selection, const fs::path& file) {
  const auto& materials = selection.bake().materials;
  const auto names = names_of(materials);
  auto library = file;
  library.replace_extension(".mtl");
  Obj obj(file, names, selection.step());
  obj.begin(library.filename(), selection);
  weld(selection, false, obj);
  write_file(library, library_of(materials, names));
  Report report;
  report.files = {file, library};
  obj.finish(report);
  return report;
}

}  // namespace hoodoo::exporting
