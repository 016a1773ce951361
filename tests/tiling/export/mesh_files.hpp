#pragma once
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "tiling/tileset/patch.hpp"

namespace hoodoo::exporting {

/// A mesh read from a file in the plainest way.
struct MeshFile {
  tileset::Patch patch;
  std::vector<Vec3> normals;
  std::vector<std::string> materials;               // of each triangle, by name or number
  std::vector<std::array<std::uint8_t, 3>> colors;  // of each vertex
  std::string header;

  /// Edges with one face, by position.
  std::size_t open_edges() const {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const auto& t : patch.triangles) {
      for (std::size_t c = 0; c < 3; ++c) {
        const auto a = t[c], b = t[(c + 1) % 3];
        sides[std::minmax(a, b)] += a < b ? 1 : 100;
      }
    }
    std::size_t open = 0;
    for (const auto& edge : sides) {
      if (edge.second == 1 || edge.second == 100) {
        ++open;
      } else {
        EXPECT_EQ(edge.second, 101) << "an edge has two faces that run along it both ways";
      }
    }
    return open;
  }
  std::size_t positions() const {
    std::set<std::array<double, 3>> all;
    for (const auto& p : patch.points) all.insert({p.x, p.y, p.z});
    return all.size();
  }
};

inline MeshFile read_obj(const std::filesystem::path& file) {
  MeshFile mesh;
  std::ifstream in(file);
  std::string line, word, material;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    words >> word;
    Vec3 v;
    if (word == "v" && words >> v.x >> v.y >> v.z) mesh.patch.points.push_back(v);
    if (word == "vn" && words >> v.x >> v.y >> v.z) mesh.normals.push_back(v);
    if (word == "usemtl") words >> material;
    if (word != "f") continue;
    lod::Triangle triangle{};
    for (auto& corner : triangle) {
      std::uint32_t normal = 0;
      char slash = 0;
      words >> corner >> slash >> slash >> normal;
      EXPECT_EQ(corner, normal);
      corner -= 1;
    }
    mesh.patch.triangles.push_back(triangle);
    mesh.materials.push_back(material);
  }
  return mesh;
}

inline MeshFile read_ply(const std::filesystem::path& file) {
  MeshFile mesh;
  std::ifstream in(file, std::ios::binary);
  std::string line;
  std::size_t vertices = 0, faces = 0;
  while (std::getline(in, line) && line != "end_header") {
    mesh.header += line + "\n";
    std::istringstream words(line);
    std::string word, kind;
    words >> word >> kind;
    if (word == "element") words >> (kind == "vertex" ? vertices : faces);
  }
  const auto get = [&](auto value) {
    in.read(reinterpret_cast<char*>(&value), sizeof value);
    return value;
  };
  for (std::size_t i = 0; i < vertices; ++i) {
    const auto p = get(std::array<double, 3>{});
    const auto n = get(std::array<float, 3>{});
    mesh.patch.points.push_back({p[0], p[1], p[2]});
    mesh.normals.push_back({n[0], n[1], n[2]});
    mesh.colors.push_back(get(std::array<std::uint8_t, 3>{}));
  }
  for (std::size_t i = 0; i < faces; ++i) {
    EXPECT_EQ(get(std::uint8_t{}), 3);
    mesh.patch.triangles.push_back(get(lod::Triangle{}));
    mesh.materials.push_back(std::to_string(get(std::uint16_t{})));
  }
  EXPECT_TRUE(in.good());
  EXPECT_EQ(in.peek(), std::ifstream::traits_type::eof());
  return mesh;
}

}  // namespace hoodoo::exporting
