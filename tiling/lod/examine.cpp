#include "tiling/lod/examine.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace hoodoo::lod {
namespace {

/// Bucket sides in typical edges: about ten triangles of the input meet a bucket.
constexpr double bucket_edges = 1.5;

std::vector<Vec3> as_vectors(const surface::Surface& surface) {
  std::vector<Vec3> points;
  points.reserve(surface.points.size());
  for (const auto& [x, y, z] : surface.points) {
    points.push_back({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
  }
  return points;
}

/// Mean length of the triangles' first edges.
double typical_edge(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles) {
  double sum = 0;
  for (const auto& t : triangles) sum += length(points[t[1]] - points[t[0]]);
  return std::max(1.0, sum / static_cast<double>(std::max<std::size_t>(1, triangles.size())));
}

/// Edges between triangles of different materials, as segments (a, b, b).
std::vector<Triangle> material_borders(const HalfEdges& edges,
                                       std::span<const std::uint16_t> materials) {
  std::vector<Triangle> borders;
  if (std::ranges::adjacent_find(materials, std::ranges::not_equal_to()) == materials.end()) {
    return borders;
  }
  for (std::uint32_t v = 0; v < edges.vertices(); ++v) {
    for (const auto& edge : edges.from(v)) {
      if (edge.to < v) continue;
      const auto* partner = edges.find(edge.to, v);
      if (partner != nullptr && materials[partner->triangle] != materials[edge.triangle]) {
        borders.push_back({v, edge.to, edge.to});
      }
    }
  }
  return borders;
}

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

}  // namespace

Examiner::Examiner(const surface::Surface& surface)
    : surface_(surface),
      points_(as_vectors(surface)),
      spacing_(typical_edge(points_, surface.triangles)),
      edges_(surface.triangles, surface.points.size()),
      topology_(topology(surface.triangles, edges_)),
      borders_(material_borders(edges_, surface.materials)),
      buckets_(points_, surface.triangles, bucket_edges * spacing_) {}

void Examiner::mark(const Vec3& p, double reach, std::vector<bool>& marked) const {
  buckets_.for_each_near(p, reach, [&](std::uint32_t t) { marked[t] = true; });
}

Findings Examiner::compare_topology(const Faces& faces, const HalfEdges& edges) const {
  const Topology after = topology(faces.triangles, edges);
  std::vector<std::uint32_t> faulty = after.faulty;
  add_difference(
      with_materials(topology_.open, surface_.materials),
      with_materials(after.open, faces.materials),
      [](const Topology::Open& edge) { return edge.from; }, faulty);
  add_difference(
      topology_.split, after.split, [](const Topology::Fans& fans) { return fans.vertex; }, faulty);
  add_difference(
      chords(edges_, surface_.planes), chords(edges, surface_.planes),
      [](const auto& chord) { return chord.first; }, faulty);
  Findings findings;
  for (const auto vertex : faulty) findings.faults.push_back(points_[vertex]);
  findings.torn = faulty.empty() && after.euler != topology_.euler;
  return findings;
}

/// The distances between the two surfaces, and the faults met on the way.
class Examiner::Survey {
 public:
  Survey(const Examiner& input, const Faces& faces, const HalfEdges& edges, double error,
         std::size_t most_faults, Findings findings)
      : input_(input),
        faces_(faces),
        edges_(edges),
        error_(error),
        most_faults_(most_faults),
        findings_(std::move(findings)) {}

  void input_against_result();
  void result_against_input();
  void material_borders_both_ways();

  Findings take() {
    findings_.error = worst_;
    return std::move(findings_);
  }

 private:
  bool enough() const { return findings_.faults.size() > most_faults_; }
  void look(const Vec3& p, const Buckets& other, Farthest& farthest) {
    if (!farthest.look(p, other)) findings_.faults.push_back(p);
  }
  void end(const Farthest& farthest) { worst_ = std::max(worst_, farthest.distance()); }
  void follow(const std::vector<Triangle>& from, const std::vector<Triangle>& to);

  const Examiner& input_;
  const Faces& faces_;
  const HalfEdges& edges_;
  double error_;
  std::size_t most_faults_;
  double worst_ = 0;
  Findings findings_;
};

/// Vertices that are gone and centres of triangles.
void Examiner::Survey::input_against_result() {
  const auto& p = input_.points_;
  const Buckets result(p, faces_.triangles, bucket_edges * input_.spacing_);
  Farthest farthest(error_, error_ / 64);
  std::vector<bool> seen(p.size());
  for (const auto& triangle : input_.surface_.triangles) {
    if (enough()) break;
    if (kept(triangle, edges_)) continue;
    for (const auto vertex : triangle) {
      if (seen[vertex] || !edges_.from(vertex).empty()) continue;
      seen[vertex] = true;
      look(p[vertex], result, farthest);
    }
    const auto& [a, b, c] = triangle;
    look((p[a] + p[b] + p[c]) * (1.0 / 3), result, farthest);
  }
  end(farthest);
}

/// Samples a typical edge apart.
void Examiner::Survey::result_against_input() {
  const auto& p = input_.points_;
  Farthest farthest(error_, error_ / 64);
  for (const auto& triangle : faces_.triangles) {
    if (enough()) break;
    if (kept(triangle, input_.edges_)) continue;
    const auto& [a, b, c] = triangle;
    for_each_sample(p[a], p[b], p[c], input_.spacing_,
                    [&](const Vec3& sample) { look(sample, input_.buckets_, farthest); });
    look((p[a] + p[b] + p[c]) * (1.0 / 3), input_.buckets_, farthest);
  }
  end(farthest);
}

void Examiner::Survey::follow(const std::vector<Triangle>& from, const std::vector<Triangle>& to) {
  const auto& p = input_.points_;
  const Buckets other(p, to, bucket_edges * input_.spacing_);
  Farthest farthest(error_, error_ / 64);
  for (const auto& [a, b, end] : from) {
    if (enough()) break;
    if (other.empty()) {
      findings_.faults.push_back(p[a]);
      continue;
    }
    look(p[a], other, farthest);
    look(p[b], other, farthest);
    for_each_sample(p[a], p[b], p[end], input_.spacing_,
                    [&](const Vec3& sample) { look(sample, other, farthest); });
  }
  end(farthest);
}

void Examiner::Survey::material_borders_both_ways() {
  const auto borders = material_borders(edges_, faces_.materials);
  follow(input_.borders_, borders);
  follow(borders, input_.borders_);
}

Findings Examiner::examine(const Faces& faces, double error, std::size_t most_faults) const {
  const HalfEdges edges(faces.triangles, points_.size());
  Findings topological = compare_topology(faces, edges);
  if (topological.torn || topological.faults.size() > most_faults) return topological;
  Survey survey(*this, faces, edges, error, most_faults, std::move(topological));
  survey.input_against_result();
  survey.result_against_input();
  survey.material_borders_both_ways();
  return survey.take();
}

}  // namespace hoodoo::lod
