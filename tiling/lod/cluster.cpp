#include "tiling/lod/cluster.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "engine/base/vector.hpp"
#include "tiling/lod/buckets.hpp"

namespace hoodoo::lod {
namespace {

constexpr std::uint32_t none = ~0U;
constexpr double infinity = std::numeric_limits<double>::infinity();
/// Triangles of a cluster face at most 60 degrees from their mean.
constexpr double least_cosine2 = 0.25;
/// What a cluster given up changes around it is looked at again, so many times.
constexpr int most_rounds = 64;
/// A result with more than this share of the triangles is not worth its error.
constexpr double most_left = 0.8;

/// The vertices in one block.
struct Cluster {
  std::int32_t z = 0;              // of its block
  std::uint32_t next = none;       // cluster in the same column of blocks
  std::uint32_t vertex = none;     // takes the place of all
  double from_middle2 = infinity;  // of that vertex
  Vec3 normal;                     // mean of the triangles around, of length 1
};

class Clustering {
 public:
  Clustering(const surface::Surface& surface, int block, double error)
      : surface_(surface), block_(block), error2_(error * error) {}

  /// False when no clustering was found that keeps to the conditions.
  bool run() {
    lock();
    assign();
    sum_normals();
    look_at_input();
    distance2_.resize(surface_.points.size());
    for (int round = 0; round < most_rounds; ++round) {
      if (look_at_result()) return true;
    }
    return false;
  }

  Clustered take() const {
    Clustered result;
    auto& out = result.surface;
    std::vector<std::uint32_t> renamed(surface_.points.size(), none);
    for (std::uint32_t v = 0; v < renamed.size(); ++v) {
      if (instead_[v] != v) {
        result.error = std::max(result.error, distance2_[v]);
        continue;
      }
      renamed[v] = static_cast<std::uint32_t>(result.kept.size());
      result.kept.push_back(v);
      out.points.push_back(surface_.points[v]);
      out.planes.push_back(surface_.planes[v]);
    }
    result.error = std::sqrt(result.error);
    for (std::size_t t = 0; t < surface_.triangles.size(); ++t) {
      const auto [a, b, c] = instead_of(surface_.triangles[t]);
      if (a == b || b == c || c == a) continue;
      out.triangles.push_back({renamed[a], renamed[b], renamed[c]});
      out.materials.push_back(surface_.materials[t]);
    }
    return result;
  }

 private:
  Vec3 at(std::uint32_t v) const {
    const auto& [x, y, z] = surface_.points[v];
    return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
  }
  Vec3 normal(const Triangle& t) const {
    const Vec3 a = at(t[0]);
    return cross(at(t[1]) - a, at(t[2]) - a);
  }
  Triangle instead_of(const Triangle& t) const {
    return {instead_[t[0]], instead_[t[1]], instead_[t[2]]};
  }
  /// Each cluster of the corners, once.
  template <class Visit>
  void for_each_cluster(const Triangle& triangle, Visit visit) {
    const auto a = cluster_[triangle[0]], b = cluster_[triangle[1]], c = cluster_[triangle[2]];
    if (a != none) visit(a);
    if (b != none && b != a) visit(b);
    if (c != none && c != a && c != b) visit(c);
  }
  bool faces(std::uint32_t cluster, const Vec3& normal) const {
    const double along = dot(clusters_[cluster].normal, normal);
    return along > 0 && along * along >= least_cosine2 * dot(normal, normal);
  }

  /// Vertices on borders and between materials are in no cluster.
  void lock() {
    cluster_.resize(surface_.points.size());
    for (std::size_t v = 0; v < cluster_.size(); ++v) {
      cluster_[v] = surface_.planes[v] == 0 ? 0 : none;
    }
    const auto& materials = surface_.materials;
    if (std::ranges::adjacent_find(materials, std::ranges::not_equal_to()) == materials.end()) {
      return;
    }
    std::vector<std::uint32_t> first(cluster_.size(), none);
    for (std::size_t t = 0; t < materials.size(); ++t) {
      for (const auto v : surface_.triangles[t]) {
        if (first[v] == none) first[v] = materials[t];
        if (first[v] != materials[t]) cluster_[v] = none;
      }
    }
  }

  /// The blocks are numbered from the lowest that the surface reaches.
  void assign() {
    surface::Point low = surface_.points.front(), high = low;
    for (const auto& p : surface_.points) {
      for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], p[a]);
        high[a] = std::max(high[a], p[a]);
      }
    }
    for (auto& at : low) {
      at = static_cast<std::int32_t>(std::floor(static_cast<double>(at) / block_)) * block_;
    }
    const double per_block = 1.0 / block_;
    const auto block_of = [&](const surface::Point& p, std::size_t axis) {
      return static_cast<std::int32_t>((p[axis] - low[axis]) * per_block);
    };
    const auto width = static_cast<std::size_t>(block_of(high, 0)) + 1;
    std::vector<std::uint32_t> columns(width * (static_cast<std::size_t>(block_of(high, 1)) + 1),
                                       none);
    for (std::uint32_t v = 0; v < cluster_.size(); ++v) {
      if (cluster_[v] == none) continue;
      const auto& p = surface_.points[v];
      const surface::Point block{block_of(p, 0), block_of(p, 1), block_of(p, 2)};
      auto& column =
          columns[static_cast<std::size_t>(block[1]) * width + static_cast<std::size_t>(block[0])];
      auto found = column;
      while (found != none && clusters_[found].z != block[2]) found = clusters_[found].next;
      if (found == none) {
        found = static_cast<std::uint32_t>(clusters_.size());
        clusters_.emplace_back();
        clusters_.back().z = block[2];
        clusters_.back().next = std::exchange(column, found);
      }
      cluster_[v] = found;
      // The vertex nearest to one fixed place of each block is kept: on flat ground those make a
      // regular grid again.
      double from_middle2 = 0;
      for (std::size_t a = 0; a < 3; ++a) {
        const double by = p[a] - low[a] - (block[a] + 0.25) * block_;
        from_middle2 += by * by;
      }
      if (from_middle2 >= clusters_[found].from_middle2) continue;
      clusters_[found].from_middle2 = from_middle2;
      clusters_[found].vertex = v;
    }
  }

  void sum_normals() {
    for (const auto& triangle : surface_.triangles) {
      const Vec3 facing = normal(triangle);
      for_each_cluster(triangle,
                       [&](auto c) { clusters_[c].normal = clusters_[c].normal + facing; });
    }
    failed_.assign(clusters_.size(), false);
    for (std::size_t c = 0; c < clusters_.size(); ++c) {
      const double size = length(clusters_[c].normal);
      failed_[c] = !(size > 0);
      if (!failed_[c]) clusters_[c].normal = clusters_[c].normal * (1 / size);
    }
  }

  void look_at_input() {
    for (const auto& triangle : surface_.triangles) {
      const Vec3 facing = normal(triangle);
      for_each_cluster(triangle, [&](auto c) { failed_[c] = failed_[c] || !faces(c, facing); });
    }
    marked_.assign(cluster_.size(), true);
    distance2_.assign(cluster_.size(), infinity);
    instead_.resize(cluster_.size());
    for (std::uint32_t v = 0; v < instead_.size(); ++v) {
      const auto c = cluster_[v];
      instead_[v] = c == none || failed_[c] ? v : clusters_[c].vertex;
    }
  }

  /// Looks at what clusters make of the triangles; false if some failed and were given up.
  bool look_at_result() {
    failed_.assign(clusters_.size(), false);
    for (const auto& t : surface_.triangles) {
      if (is_marked(t)) look_at(t);
    }
    for (std::uint32_t v = 0; v < instead_.size(); ++v) {
      if (instead_[v] != v && distance2_[v] > error2_) failed_[cluster_[v]] = true;
    }
    mark(failed_);
    bool good = true;
    for (std::uint32_t v = 0; v < instead_.size(); ++v) {
      if (marked_[v] == 0 || instead_[v] == v) continue;
      instead_[v] = v;
      good = false;
    }
    if (!good) look_around_failed();
    return good;
  }

  /// What lies beside clusters that failed is to be looked at again.
  void look_around_failed() {
    std::vector<std::uint8_t> again(clusters_.size());
    for (const auto& t : surface_.triangles) {
      if (is_marked(t)) for_each_cluster(t, [&](auto c) { again[c] = true; });
    }
    mark(again);
    for (std::size_t v = 0; v < marked_.size(); ++v) {
      if (marked_[v] != 0) distance2_[v] = infinity;
    }
  }

  void mark(const std::vector<std::uint8_t>& clusters) {
    for (std::size_t v = 0; v < marked_.size(); ++v) {
      marked_[v] = cluster_[v] == none ? 0 : clusters[cluster_[v]];
    }
  }
  bool is_marked(const Triangle& t) const {
    return (marked_[t[0]] | marked_[t[1]] | marked_[t[2]]) != 0;
  }

  void look_at(const Triangle& triangle) {
    const auto now = instead_of(triangle);
    const auto& [a, b, c] = now;
    if (a == b && b == c) return;
    if (a == triangle[0] && b == triangle[1] && c == triangle[2]) return;
    measure(triangle, now);
    if (a == b || b == c || c == a) return;
    const Vec3 facing = normal(now);
    std::uint32_t farthest = none;
    double most = -1;
    bool upright = true;
    for (std::size_t i = 0; i < 3; ++i) {
      if (now[i] == triangle[i]) continue;
      upright = upright && faces(cluster_[triangle[i]], facing);
      const Vec3 by = at(now[i]) - at(triangle[i]);
      if (dot(by, by) <= most) continue;
      most = dot(by, by);
      farthest = triangle[i];
    }
    if (!upright) failed_[cluster_[farthest]] = true;
  }

  /// How far the corners that go are from what the triangle becomes, which may be an edge.
  void measure(const Triangle& triangle, const Triangle& now) {
    const auto& [a, b, c] = now;
    const bool edge = a == b || b == c || c == a;
    const Vec3 p = at(a), q = at(a == b ? c : b), r = edge ? q : at(c);
    for (std::size_t i = 0; i < 3; ++i) {
      auto& least = distance2_[triangle[i]];
      if (now[i] == triangle[i] || least <= error2_) continue;
      const Vec3 v = at(triangle[i]);
      least = std::min(least, edge ? from_segment2(v, p, q) : distance2(v, p, q, r));
    }
  }

  static double from_segment2(const Vec3& v, const Vec3& p, const Vec3& q) {
    const Vec3 along = q - p, by = v - p;
    const double share = std::clamp(dot(by, along) / dot(along, along), 0.0, 1.0);
    const Vec3 off = by - along * share;
    return dot(off, off);
  }

  const surface::Surface& surface_;
  const int block_;
  const double error2_;
  std::vector<std::uint32_t> cluster_;  // per vertex; none: stays
  std::vector<std::uint32_t> instead_;  // per vertex: what takes its place
  std::vector<double> distance2_;       // per vertex that goes
  std::vector<std::uint8_t> failed_;    // per cluster
  std::vector<std::uint8_t> marked_;    // per vertex: to be looked at in this round
  std::vector<Cluster> clusters_;
};

}  // namespace

std::optional<Clustered> cluster(const surface::Surface& surface, int block, double error) {
  if (surface.triangles.empty() || !(error > 0)) return {};
  Clustering clustering(surface, block, error);
  if (!clustering.run()) return {};
  auto result = clustering.take();
  const auto left = static_cast<double>(result.surface.triangles.size());
  if (left > most_left * static_cast<double>(surface.triangles.size())) return {};
  return result;
}

bool same_topology(const surface::Surface& before, const Clustered& after,
                   const Topology& topology) {
  const auto& planes = after.surface.planes;
  const auto at_border = [&](std::uint32_t v) { return planes[v] != 0; };
  // Vertices on borders stay, and so do the triangles on them: as many edges are open as before,
  // and all others have two half-edges.
  const auto edges = (3 * before.triangles.size() + topology.open.size()) / 2;
  const auto euler = static_cast<std::int64_t>(before.points.size() + before.triangles.size()) -
                     static_cast<std::int64_t>(edges);
  return topology.sound() && topology.euler == euler &&
         std::ranges::all_of(topology.split, at_border, &Topology::Fans::vertex) &&
         std::ranges::all_of(topology.open, [&](const Topology::Open& edge) {
           return at_border(edge.from) && at_border(edge.to);
         });
}

}  // namespace hoodoo::lod
