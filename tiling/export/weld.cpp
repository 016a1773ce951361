#include "tiling/export/weld.hpp"

#include "engine/base/random.hpp"

namespace hoodoo::exporting {

std::size_t Weld::Hash::operator()(const Name& name) const {
  const auto& p = name.position;
  return random_bits(static_cast<std::uint64_t>(p[0]), p[1], p[2], name.material);
}

Piece Weld::add(const plan::Key& key, const glb::Decoded& tile) {
  if (key.y != row_) {  // no tile reaches below its row
    std::erase_if(border_,
                  [&](const auto& held) { return held.first.position[1] < key.y * side_; });
    row_ = key.y;
  }
  constexpr auto none = UINT64_MAX;
  const auto& part = tile.surface;
  Piece piece;
  Numbers inner;
  std::vector<std::uint64_t> numbers(part.points.size(), none);
  const auto number = [&](std::uint32_t vertex) {
    auto& known = numbers[vertex];
    if (known != none) return known;
    const auto& p = part.points[vertex];
    const Position at{tile.origin[0] + p[0], tile.origin[1] + p[1], tile.origin[2] + p[2]};
    const bool on_border = at[0] % side_ == 0 || at[1] % side_ == 0;
    const Name name{at, split_ ? part.materials[vertex] : std::uint16_t{0}};
    const auto entry = (on_border ? border_ : inner).try_emplace(name, vertices_);
    known = entry.first->second;
    if (!entry.second) return known;
    ++vertices_;
    piece.points.push_back(at);
    piece.normals.push_back(part.normals[vertex]);
    piece.colors.push_back(part.colors[vertex]);
    piece.materials.push_back(part.materials[vertex]);
    return known;
  };
  for (const auto& triangle : part.triangles) {
    std::array<std::uint64_t, 3> named{};
    for (std::size_t c = 0; c < 3; ++c) named[c] = number(triangle[c]);
    piece.triangles.push_back(named);
    piece.faces.push_back(part.materials[triangle[0]]);
  }
  return piece;
}

}  // namespace hoodoo::exporting
