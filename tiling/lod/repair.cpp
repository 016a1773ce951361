#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "tiling/lod/examine.hpp"
#include "tiling/lod/survey.hpp"

namespace hoodoo::lod {
namespace {

constexpr int most_rounds = 10;
/// A vertex nearer to an edge than this share of the triangle's height goes into the edge.
constexpr double thin = 0.05;

/// A result, made ready to be asked.
struct Asked {
  Asked(const Original& input, const Faces& faces)
      : edges(faces.triangles, input.points.size()),
        buckets(input.points, faces.triangles, bucket_edges * input.spacing) {}
  HalfEdges edges;
  Buckets buckets;
};

/// One round: changes to triangles that do not touch each other.
class Round {
 public:
  /// `before` is of `faces` as they are now.
  /// What was brought back in earlier rounds stays where it is.
  Round(const Original& input, Faces& faces, const Asked& before, double error,
        std::vector<std::uint32_t>& placed)
      : input_(input),
        faces_(faces),
        error_(error),
        edges_(before.edges),
        result_(before.buckets),
        touched_(faces.triangles.size()),
        placed_(placed) {}

  bool mend(const Fault& fault) {
    if (fault.kind == Fault::Kind::missed) return bring_back(fault.vertex);
    if (touched_[fault.face]) return false;
    const Triangle corners = faces_.triangles[fault.face];
    const auto any = [&](auto change) {
      const auto [a, b, c] = corners;
      return change(a, b, c) || change(b, c, a) || change(c, a, b);
    };
    const auto turned = [&](auto from, auto to, auto) { return turn(from, to); };
    const auto off_border = [&](auto u, auto v, auto x) { return turn_off(u, v, x, 16); };
    const auto moved = [&](auto v, auto, auto) { return move(v); };
    const auto merged = [&](auto u, auto v, auto) { return merge(u, v) || merge(v, u); };
    return any(off_border) || any(turned) || any(moved) || any(merged) ||
           bring_back(vertex_near(fault), fault.face);
  }

  const std::vector<Triangle>& removed() const { return removed_; }
  bool touched(std::uint32_t face) const { return touched_[face]; }

  /// Drops what was removed; the numbers of the triangles that are new, and of those in `also`.
  std::vector<std::uint32_t> finish(std::span<const std::uint32_t> also) {
    std::vector<bool> wanted(faces_.triangles.size());
    for (const auto face : changed_) wanted[face] = true;
    for (const auto face : also) wanted[face] = true;
    std::vector<std::uint32_t> numbers;
    std::uint32_t to = 0;
    for (std::uint32_t t = 0; t < faces_.triangles.size(); ++t) {
      if (std::ranges::find(dead_, t) != dead_.end()) continue;
      if (wanted[t]) numbers.push_back(to);
      faces_.triangles[to] = faces_.triangles[t];
      faces_.materials[to++] = faces_.materials[t];
    }
    faces_.triangles.resize(to);
    faces_.materials.resize(to);
    return numbers;
  }

 private:
  struct New {
    Triangle triangle;
    std::uint32_t face;  // takes its place and material
  };
  struct Change {
    std::vector<std::uint32_t> old;
    std::vector<New> fresh;
  };

  bool is_gone(std::uint32_t vertex) const {
    return edges_.from(vertex).empty() && !is_placed(vertex);
  }
  bool is_placed(std::uint32_t vertex) const {
    return std::ranges::find(placed_, vertex) != placed_.end();
  }

  /// How far `p` is from the triangle's edges, opposite each corner, as shares of its heights.
  std::array<double, 3> weights(const Vec3& p, const Triangle& triangle) const {
    const Vec3 &a = at(triangle[0]), &b = at(triangle[1]), &c = at(triangle[2]);
    const Vec3 normal = cross(b - a, c - a);
    const double square = dot(normal, normal);
    return {dot(normal, cross(c - b, p - b)) / square, dot(normal, cross(a - c, p - c)) / square,
            dot(normal, cross(b - a, p - a)) / square};
  }
  const Vec3& at(std::uint32_t vertex) const { return input_.points[vertex]; }

  /// The vertex that is gone, lies over the fault's triangle, and is nearest to the fault.
  std::uint32_t vertex_near(const Fault& fault) const {
    std::uint32_t found = ~0U;
    double least = 0;
    const auto& face = faces_.triangles[fault.face];
    input_.buckets.for_each_near(
        fault.place, fault.distance + 2 * input_.spacing, [&](std::uint32_t t) {
          for (const auto vertex : input_.surface.triangles[t]) {
            const Vec3 by = at(vertex) - fault.place;
            const double distance2 = dot(by, by);
            if (found != ~0U && distance2 >= least) continue;
            if (!is_gone(vertex) || std::ranges::min(weights(at(vertex), face)) < 0) continue;
            found = vertex;
            least = distance2;
          }
        });
    return found;
  }

  bool bring_back(std::uint32_t vertex, std::optional<std::uint32_t> into = {}) {
    if (vertex == ~0U || !is_gone(vertex)) return false;
    std::uint32_t face = 0;
    if (into) {
      face = *into;
    } else {
      result_.beyond(at(vertex), 0, face);
    }
    const auto [a, b, c] = faces_.triangles[face];
    const auto apart = weights(at(vertex), {a, b, c});
    const auto thinnest = std::ranges::min_element(apart) - apart.begin();
    const Triangle turned = thinnest == 0   ? Triangle{b, c, a}
                            : thinnest == 1 ? Triangle{c, a, b}
                                            : Triangle{a, b, c};
    const bool inside = std::ranges::min(apart) > 0;
    const bool well_inside = std::ranges::min(apart) > thin;
    const bool done = (well_inside && split_face(face, vertex)) ||
                      split_edge(face, turned, vertex) || (inside && split_face(face, vertex));
    if (done) placed_.push_back(vertex);
    return done;
  }

  bool split_face(std::uint32_t face, std::uint32_t v) {
    const auto [a, b, c] = faces_.triangles[face];
    return replace({face}, {{{a, b, v}, face}, {{b, c, v}, face}, {{c, a, v}, face}});
  }

  /// Splits the edge between the first two corners of `face`, and the triangle across.
  bool split_edge(std::uint32_t face, const Triangle& corners, std::uint32_t v) {
    const auto [x, y, z] = corners;
    const auto* partner = edges_.find(y, x);
    if (partner == nullptr) return false;
    const std::uint32_t other = partner->triangle, w = partner->apex;
    return replace({face, other},
                   {{{x, v, z}, face}, {{v, y, z}, face}, {{y, v, w}, other}, {{v, x, w}, other}});
  }

  /// Turns an edge within one material.
  bool turn(std::uint32_t from, std::uint32_t to) {
    const auto turned = pair_at(from, to);
    return turned && near(*turned) && replace(turned->old, turned->fresh);
  }

  /// Turns an edge away from the border that all of its triangle lies in; where the triangle across
  /// does, too, one of that one's, up to `depth` times. Whether the new two are near enough is
  /// found out with all that changed: they may need a vertex more.
  bool turn_off(std::uint32_t from, std::uint32_t to, std::uint32_t apex, int depth) {
    const auto& planes = input_.surface.planes;
    const int shared = planes[from] & planes[to] & planes[apex];
    const auto* across = edges_.find(to, from);
    if (shared == 0 || across == nullptr || depth == 0) return false;
    const auto far = across->apex;
    if ((planes[far] & shared) != 0) {
      return turn_off(from, far, to, depth - 1) || turn_off(far, to, from, depth - 1);
    }
    const auto turned = pair_at(from, to);
    return turned && put(turned->old, turned->fresh);
  }

  std::optional<Change> pair_at(std::uint32_t from, std::uint32_t to) const {
    const auto *one = edges_.find(from, to), *other = edges_.find(to, from);
    if (one == nullptr || other == nullptr) return {};
    const Turn turned{from, to, one->apex, other->apex};
    const auto& planes = input_.surface.planes;
    if (turned.x == turned.y || (planes[turned.x] & planes[turned.y]) != 0 ||
        faces_.materials[one->triangle] != faces_.materials[other->triangle] ||
        edges_.find(turned.x, turned.y) || edges_.find(turned.y, turned.x)) {
      return {};
    }
    return Change{{one->triangle, other->triangle},
                  {{turned.first(), one->triangle}, {turned.second(), other->triangle}}};
  }

  /// An inner vertex within one material, whose triangles are to change; false for another.
  bool around(std::uint32_t vertex, std::vector<std::uint32_t>& faces) const {
    if (input_.surface.planes[vertex] != 0 || is_placed(vertex)) return false;
    const auto all = edges_.from(vertex);
    for (const auto& edge : all) {
      if (edges_.find(edge.to, vertex) == nullptr ||
          faces_.materials[edge.triangle] != faces_.materials[all.front().triangle]) {
        return false;
      }
      faces.push_back(edge.triangle);
    }
    return !faces.empty();
  }

  /// Puts an inner vertex in the place of one that is gone, its neighbour in the input.
  bool move(std::uint32_t vertex) {
    std::vector<std::uint32_t> old;
    if (!around(vertex, old)) return false;
    for (const auto& way : input_.edges.from(vertex)) {
      if (!is_gone(way.to)) continue;
      std::vector<New> fresh;
      for (const auto& edge : edges_.from(vertex)) {
        fresh.push_back({{way.to, edge.to, edge.apex}, edge.triangle});
      }
      if (!near({old, fresh}) || !replace(old, fresh)) continue;
      placed_.push_back(way.to);
      return true;
    }
    return false;
  }

  /// Merges an inner vertex into a neighbour, where the surface stays manifold.
  bool merge(std::uint32_t from, std::uint32_t into) {
    const auto& planes = input_.surface.planes;
    std::vector<std::uint32_t> old;
    if (!around(from, old)) return false;
    std::vector<New> fresh;
    std::size_t common = 0;
    for (const auto& edge : edges_.from(from)) {
      if (edges_.find(into, edge.to) || edges_.find(edge.to, into)) ++common;
      if (edge.to == into || edge.apex == into) continue;
      if ((planes[into] & (planes[edge.to] | planes[edge.apex])) != 0) return false;
      fresh.push_back({{into, edge.to, edge.apex}, edge.triangle});
    }
    return common == 2 && old.size() == fresh.size() + 2 && near({old, fresh}) &&
           replace(old, fresh);
  }

  /// The new triangles are within the error of the input.
  bool near(const Change& change) const {
    Farthest farthest(error_, error_);
    return std::ranges::all_of(change.fresh, [&](const New& n) {
      const auto& [a, b, c] = n.triangle;
      bool good = farthest.look((at(a) + at(b) + at(c)) * (1.0 / 3), input_.buckets);
      for_each_sample(at(a), at(b), at(c), sample_edges * input_.spacing,
                      [&](const Vec3& p) { good = good && farthest.look(p, input_.buckets); });
      return good;
    });
  }

  /// Puts triangles in the place of others where all face the input's way.
  bool replace(const std::vector<std::uint32_t>& old, const std::vector<New>& fresh) {
    std::uint32_t hint = 0;
    return std::ranges::all_of(
               fresh, [&](const New& n) { return input_.upright(n.triangle, error_, hint); }) &&
           put(old, fresh);
  }

  /// Puts triangles in the place of others; false where one of those has changed already.
  bool put(const std::vector<std::uint32_t>& old, const std::vector<New>& fresh) {
    if (std::ranges::any_of(old, [&](auto face) { return touched_[face]; })) return false;
    for (const auto face : old) {
      touched_[face] = true;
      removed_.push_back(faces_.triangles[face]);
    }
    std::vector<std::uint32_t> taken;
    for (const auto& n : fresh) {
      if (std::ranges::find(taken, n.face) == taken.end()) {
        taken.push_back(n.face);
        faces_.triangles[n.face] = n.triangle;
        changed_.push_back(n.face);
      } else {
        changed_.push_back(static_cast<std::uint32_t>(faces_.triangles.size()));
        const auto material = faces_.materials[n.face];
        faces_.triangles.push_back(n.triangle);
        faces_.materials.push_back(material);
      }
    }
    for (const auto face : old) {
      if (std::ranges::find(taken, face) == taken.end()) dead_.push_back(face);
    }
    return true;
  }

  const Original& input_;
  Faces& faces_;
  double error_;
  const HalfEdges& edges_;  // as the round began, like `result_`
  const Buckets& result_;
  std::vector<bool> touched_;
  std::vector<std::uint32_t>& placed_;
  std::vector<std::uint32_t> changed_, dead_;
  std::vector<Triangle> removed_;
};

/// The triangles of the input for which the triangles removed may have answered, and those at
/// faults.
std::vector<std::uint32_t> to_ask_again(const Original& input, double error,
                                        const std::vector<Triangle>& removed,
                                        const std::vector<Fault>& faults) {
  std::vector<std::uint32_t> found;
  const auto add = [&](const Vec3& place, double reach) {
    input.buckets.for_each_near(place, reach, [&](std::uint32_t t) { found.push_back(t); });
  };
  const auto& p = input.points;
  for (const auto& [a, b, c] : removed) {
    const Vec3 middle = (p[a] + p[b] + p[c]) * (1.0 / 3);
    double radius2 = 0;
    for (const auto corner : {a, b, c}) {
      radius2 = std::max(radius2, dot(p[corner] - middle, p[corner] - middle));
    }
    add(middle, std::sqrt(radius2) + error + 1);
  }
  for (const auto& fault : faults) {
    if (fault.kind == Fault::Kind::missed) add(fault.place, 1);
  }
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

/// Examines the triangles `changed` of the result, and those of the input in `again`.
Findings ask_again(const Original& input, const Faces& faces, const Asked& after, double error,
                   std::span<const std::uint32_t> changed, std::span<const std::uint32_t> again,
                   double so_far) {
  Findings findings;
  findings.error = so_far;
  std::uint32_t hint = 0;
  const auto& p = input.points;
  for (const auto face : changed) {
    const auto& triangle = faces.triangles[face];
    if (kept(triangle, input.edges) || input.upright(triangle, error, hint)) continue;
    const auto& [a, b, c] = triangle;
    findings.faults.push_back(
        {Fault::Kind::folded, (p[a] + p[b] + p[c]) * (1.0 / 3), 0, face, ~0U});
  }
  Survey survey(input, faces, after.edges, error, ~std::size_t{0}, std::move(findings));
  survey.input_against_result(again, after.buckets);
  survey.result_against_input(changed);
  survey.material_borders_both_ways();
  return survey.take();
}

bool can_be_mended(const Fault& fault) {
  return fault.kind != Fault::Kind::topology && fault.kind != Fault::Kind::border_off;
}

}  // namespace

Findings repair(const Original& input, Faces& faces, double error, Findings findings) {
  if (findings.good()) return findings;
  std::optional<Asked> asked(std::in_place, input, faces);
  std::vector<std::uint32_t> placed;
  for (int round = 0; round < most_rounds && !findings.faults.empty(); ++round) {
    if (!std::ranges::all_of(findings.faults, can_be_mended)) return findings;
    auto& faults = findings.faults;
    // The farthest first: what it brings back often serves those around it.
    std::ranges::stable_sort(faults, std::ranges::greater(), &Fault::distance);
    Round changes(input, faces, *asked, error, placed);
    bool any = false;
    for (const auto& fault : faults) any = changes.mend(fault) || any;
    if (!any) return findings;
    std::vector<std::uint32_t> at_faults;
    for (const auto& fault : faults) {
      if (fault.face != ~0U && !changes.touched(fault.face)) at_faults.push_back(fault.face);
    }
    const auto changed = changes.finish(at_faults);
    const auto again = to_ask_again(input, error, changes.removed(), faults);
    asked.emplace(input, faces);
    findings = ask_again(input, faces, *asked, error, changed, again, findings.error);
  }
  if (!findings.good()) return findings;
  Findings topological = compare_topology(input, faces, asked->edges);
  topological.error = findings.error;
  return topological;
}

}  // namespace hoodoo::lod
