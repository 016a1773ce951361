#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "tiling/lod/deviation.hpp"
#include "tiling/lod/examine.hpp"

namespace hoodoo::lod {

/// Samples of a result are so many typical edges apart.
inline constexpr double sample_edges = 2;

/// The distances between a surface and what it was simplified to, and the faults met on the way.
class Survey {
 public:
  /// Adds to `findings`, until there are more than `most_faults`.
  Survey(const Original& input, const Faces& faces, const HalfEdges& edges, double error,
         std::size_t most_faults, Findings findings)
      : input_(input),
        faces_(faces),
        edges_(edges),
        error_(error),
        most_faults_(most_faults),
        findings_(std::move(findings)) {}

  /// Vertices that are gone, and centres of triangles, of those triangles of the input. A triangle
  /// whose corners are near one triangle of the result lies as near to it throughout, since that is
  /// convex. `result` are the result's triangles.
  void input_against_result(std::span<const std::uint32_t> which, const Buckets& result);

  /// Samples and centres, of those triangles of the result.
  void result_against_input(std::span<const std::uint32_t> which);

  void material_borders_both_ways();

  Findings take() { return std::move(findings_); }

 private:
  bool enough() const { return findings_.faults.size() > most_faults_; }
  void end(const Farthest& farthest) {
    findings_.error = std::max(findings_.error, farthest.distance());
  }
  void follow(const std::vector<Triangle>& from, const std::vector<Triangle>& to);
  bool is_gone(std::uint32_t vertex) const { return edges_.from(vertex).empty(); }
  std::uint32_t farthest_gone(const Triangle& triangle, const Buckets& result) const;

  const Original& input_;
  const Faces& faces_;
  const HalfEdges& edges_;
  double error_;
  std::size_t most_faults_;
  Findings findings_;
};

}  // namespace hoodoo::lod
