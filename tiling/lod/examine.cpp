#include "tiling/lod/examine.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "tiling/lod/survey.hpp"

namespace hoodoo::lod {
namespace {

/// Vertices at which two sorted lists differ.
template <class Entry, class Vertex>
void add_difference(const std::vector<Entry>& a, const std::vector<Entry>& b, Vertex vertex,
                    std::vector<std::uint32_t>& out) {
  std::vector<Entry> different;
  std::ranges::set_symmetric_difference(a, b, std::back_inserter(different));
  for (const auto& entry : different) out.push_back(vertex(entry));
}

/// Open edges with materials in place of triangles.
std::vector<Topology::Open> with_materials(std::vector<Topology::Open> open,
                                           std::span<const std::uint16_t> materials) {
  for (auto& edge : open) edge.triangle = materials[edge.triangle];
  return open;
}

std::vector<std::uint32_t> all_of(const std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> numbers(triangles.size());
  std::iota(numbers.begin(), numbers.end(), 0U);
  return numbers;
}

}  // namespace

Findings compare_topology(const Original& input, const Faces& faces, const HalfEdges& edges) {
  const Topology after = topology(faces.triangles, edges);
  const auto& planes = input.surface.planes;
  std::vector<std::uint32_t> faulty = after.faulty;
  add_difference(
      with_materials(input.topology.open, input.surface.materials),
      with_materials(after.open, faces.materials),
      [](const Topology::Open& edge) { return edge.from; }, faulty);
  add_difference(
      input.topology.split, after.split, [](const Topology::Fans& fans) { return fans.vertex; },
      faulty);
  add_difference(
      input.chords, chords(edges, planes), [](const auto& chord) { return chord.first; }, faulty);
  Findings findings;
  for (const auto vertex : faulty) {
    findings.faults.push_back({Fault::Kind::topology, input.points[vertex]});
  }
  findings.torn = faulty.empty() && after.euler != input.topology.euler;
  return findings;
}

Findings examine(const Original& input, const Faces& faces, double error, std::size_t most_faults) {
  const HalfEdges edges(faces.triangles, input.points.size());
  Findings topological = compare_topology(input, faces, edges);
  if (topological.torn || topological.faults.size() > most_faults) return topological;
  Survey survey(input, faces, edges, error, most_faults, std::move(topological));
  const Buckets result(input.points, faces.triangles, bucket_edges * input.spacing);
  survey.input_against_result(all_of(input.surface.triangles), result);
  survey.result_against_input(all_of(faces.triangles));
  survey.material_borders_both_ways();
  return survey.take();
}

}  // namespace hoodoo::lod
