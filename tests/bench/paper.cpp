#include "tests/bench/paper.hpp"

#include <algorithm>
#include <cmath>

#include "tests/bench/measure.hpp"
#include "tiling/surface/tables.hpp"

namespace hoodoo::bench {
namespace {

constexpr std::uint32_t none = ~0U;
constexpr float tolerance = 1e-4F;  // of an edge

float step(float u) {
  const float c = std::clamp(u, -1.0F, 1.0F);
  return 0.5F + 0.5F * (c * (1.5F - 0.5F * (c * c)));
}

/// A cell's triangles as corners on its edges, numbered as in tiling/surface.
struct Triangles {
  std::array<std::array<std::uint8_t, 3>, 8> edges{};
  std::size_t count = 0;
};

unsigned low_corner(unsigned edge) {
  const std::size_t a = edge / 4;
  return (edge & 1) << surface::next_axis(a) | (edge >> 1 & 1) << surface::last_axis(a);
}

/// The edge of a face that joins its corners k and k + 1.
unsigned face_edge(unsigned face, int k) {
  const unsigned a = face / 2, side = face & 1;
  const auto u = static_cast<unsigned>(surface::next_axis(a));
  const auto v = static_cast<unsigned>(surface::last_axis(a));
  return k == 0   ? 4 * u + 2 * side
         : k == 1 ? 4 * v + side + 2
         : k == 2 ? 4 * u + 1 + 2 * side
                  : 4 * v + side;
}

/// Which edge follows each along the loops of a cell: through one of its two faces.
std::array<std::array<int, 2>, 12> joined_edges(unsigned mask) {
  std::array<std::array<int, 2>, 12> joined;
  joined.fill({-1, -1});
  for (unsigned face = 0; face < 6; ++face) {
    const std::size_t a = face / 2, u = surface::next_axis(a), v = surface::last_axis(a);
    constexpr std::array<unsigned, 4> along_u{0, 1, 1, 0}, along_v{0, 0, 1, 1};
    unsigned corners = 0;
    for (unsigned k = 0; k < 4; ++k) {
      const unsigned corner = (face & 1) << a | along_u[k] << u | along_v[k] << v;
      corners |= (mask >> corner & 1) << k;
    }
    const auto pairs = surface::face_case(corners);
    for (int s = 0; s < pairs.count; ++s) {
      const auto& segment = pairs.segments[static_cast<std::size_t>(s)];
      const auto e = face_edge(face, segment.first), f = face_edge(face, segment.second);
      const auto link = [&](unsigned from, unsigned to) {
        auto& both = joined[from];
        both[both[0] < 0 ? 0 : 1] = static_cast<int>(to);
      };
      link(e, f);
      link(f, e);
    }
  }
  return joined;
}

/// Each loop cut into a fan.
Triangles triangles_of(unsigned mask) {
  const auto joined = joined_edges(mask);
  Triangles result;
  unsigned seen = 0;
  for (unsigned start = 0; start < 12; ++start) {
    if (joined[start][0] < 0 || (seen >> start & 1) != 0) continue;
    std::vector<unsigned> loop;
    for (unsigned edge = start; (seen >> edge & 1) == 0;) {
      seen |= 1U << edge;
      loop.push_back(edge);
      const auto next = static_cast<unsigned>(joined[edge][0]);
      edge = (seen >> next & 1) == 0 ? next : static_cast<unsigned>(joined[edge][1]);
    }
    for (std::size_t n = 2; n < loop.size(); ++n) {
      result.edges[result.count++] = {static_cast<std::uint8_t>(loop[0]),
                                      static_cast<std::uint8_t>(loop[n - 1]),
                                      static_cast<std::uint8_t>(loop[n])};
    }
  }
  return result;
}

const std::array<Triangles, 256>& cube_cases() {
  static const auto table = [] {
    std::array<Triangles, 256> t;
    for (unsigned mask = 0; mask < 256; ++mask) t[mask] = triangles_of(mask);
    return t;
  }();
  return table;
}

}  // namespace

Paper::Paper(const Scene& scene) : scene_(scene), hierarchy_(scene.balls) {}

float Paper::field(float x, float y, float z, float h) {
  ++result_.calls;
  return std::clamp(step((h - z) / ground_falloff) + hierarchy_.sum(x, y, z), 0.0F, 1.0F);
}

Paper::Result Paper::run() {
  result_ = {};
  const double from = processor_seconds();
  look_up_elevations();
  result_.looking_up = processor_seconds() - from;
  find_bounds();
  dilate();
  vertices_ = 0;
  sample(0, rows_[0]);
  for (int j = 0; j + 1 < scene_.wide; ++j) {
    sample(j + 1, rows_[1]);
    add_cells(j);
    std::swap(rows_[0], rows_[1]);
  }
  result_.vertices = vertices_;
  return result_;
}

void Paper::look_up_elevations() {
  heights_.resize(column(0, scene_.wide));
  for (int j = 0; j < scene_.wide; ++j) {
    for (int i = 0; i < scene_.wide; ++i) {
      heights_[column(i, j)] = static_cast<float>(scene_.window.height(i, j));
    }
  }
}

void Paper::find_bounds() {
  own_.resize(column(0, scene_.wide));
  covered_.assign(own_.size(), false);
  for (int j = 0; j < scene_.wide; ++j) {
    for (int i = 0; i < scene_.wide; ++i) {
      const auto at = static_cast<int>(std::floor(heights_[column(i, j)]));
      std::array<int, 2> range{at, at};
      if (hierarchy_.join_bounds(static_cast<float>(i), static_cast<float>(j), range)) {
        covered_[column(i, j)] = true;
        ++result_.covered;
      }
      own_[column(i, j)] = {range[0], range[1]};
    }
  }
}

void Paper::dilate() {
  dilated_.resize(own_.size());
  const int n = scene_.wide;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      Bounds joined = own_[column(i, j)];
      for (int q = std::max(j - 1, 0); q <= std::min(j + 1, n - 1); ++q) {
        for (int p = std::max(i - 1, 0); p <= std::min(i + 1, n - 1); ++p) {
          const Bounds& other = own_[column(p, q)];
          joined.low = std::min(joined.low, other.low);
          joined.high = std::max(joined.high, other.high);
        }
      }
      dilated_[column(i, j)] = joined;
    }
  }
}

/// A cell between bounds has points at both, and one above.
void Paper::sample(int j, Row& row) {
  row.first.resize(static_cast<std::size_t>(scene_.wide));
  row.values.clear();
  for (int i = 0; i < scene_.wide; ++i) {
    const auto [low, high] = dilated_[column(i, j)];
    row.first[static_cast<std::size_t>(i)] = row.values.size() - static_cast<std::size_t>(low);
    const float h = heights_[column(i, j)];
    for (int k = low; k <= high + 1; ++k) {
      row.values.push_back(
          field(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k), h));
    }
  }
  for (auto& vertex : row.vertex) vertex.assign(row.values.size(), none);
}

void Paper::add_cells(int j) {
  points_.clear();
  triangles_.clear();
  for (int i = 0; i + 1 < scene_.wide; ++i) {
    Bounds range = own_[column(i, j)];
    for (const auto& other :
         {own_[column(i + 1, j)], own_[column(i, j + 1)], own_[column(i + 1, j + 1)]}) {
      range.low = std::min(range.low, other.low);
      range.high = std::max(range.high, other.high);
    }
    const auto x = static_cast<std::size_t>(i);
    for (int k = range.low; k <= range.high; ++k) {
      unsigned mask = 0;
      for (unsigned corner = 0; corner < 8; ++corner) {
        const Row& row = rows_[corner >> 1 & 1];
        const auto at = row.first[x + (corner & 1)] + static_cast<std::size_t>(k) + (corner >> 2);
        mask |= (row.values[at] > 0.5F ? 1U : 0U) << corner;
      }
      if (mask != 0 && mask != 255) add_cell(i, j, k, mask);
    }
  }
  result_.triangles += triangles_.size();
}

void Paper::add_cell(int i, int j, int k, unsigned mask) {
  const Triangles& cell = cube_cases()[mask];
  for (std::size_t t = 0; t < cell.count; ++t) {
    std::array<std::uint32_t, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) corners[c] = vertex(i, j, k, cell.edges[t][c]);
    triangles_.push_back(corners);
  }
}

std::uint32_t Paper::vertex(int i, int j, int k, unsigned edge) {
  const unsigned corner = low_corner(edge), axis = edge / 4;
  const int x = i + static_cast<int>(corner & 1), z = k + static_cast<int>(corner >> 2);
  const int y = j + static_cast<int>(corner >> 1 & 1);
  Row& row = rows_[corner >> 1 & 1];
  const auto at = row.first[static_cast<std::size_t>(x)] + static_cast<std::size_t>(z);
  auto& index = row.vertex[axis][at];
  if (index != none) return index;
  const float t = cross(x, y, z, static_cast<int>(axis), row.values[at]);
  Point p{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
  p[axis] += t;
  points_.push_back(p);
  index = static_cast<std::uint32_t>(vertices_++);
  return index;
}

float Paper::cross(int i, int j, int k, int axis, float low) {
  const int p = i + (axis == 0 ? 1 : 0), q = j + (axis == 1 ? 1 : 0);
  const auto x = static_cast<float>(i), y = static_cast<float>(j), z = static_cast<float>(k);
  const float from = heights_[column(i, j)], to = heights_[column(p, q)];
  if (!covered_[column(i, j)] && !covered_[column(p, q)]) {
    return axis == 2 ? from - z : (z - from) / (to - from);
  }
  float near = 0, far = 1;
  while (far - near > tolerance) {
    const float t = 0.5F * (near + far);
    const float u = axis == 0 ? x + t : x, v = axis == 1 ? y + t : y, w = axis == 2 ? z + t : z;
    const float h = axis == 2 ? from
                              : static_cast<float>(scene_.window.height(static_cast<double>(u),
                                                                        static_cast<double>(v)));
    ((field(u, v, w, h) > 0.5F) == (low > 0.5F) ? near : far) = t;
  }
  return 0.5F * (near + far);
}

}  // namespace hoodoo::bench
