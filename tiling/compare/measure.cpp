#include "tiling/compare/measure.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/math.hpp"
#include "tiling/lod/deviation.hpp"

namespace hoodoo::compare {
namespace {

/// Squared distance of a point from a box.
double distance2(const Vec3& p, const Box& box) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double out = std::max({box.min[axis] - p[axis], p[axis] - box.max[axis], 0.0});
    sum += out * out;
  }
  return sum;
}

Vec3 vector_of(const Vec3f& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

/// The normal of a surface at the place of a triangle nearest to `p`, interpolated.
Vec3 normal_near(const Vec3& p, const Sheet& sheet, std::uint32_t triangle) {
  const auto& [ia, ib, ic] = sheet.patch.triangles[triangle];
  const Vec3 &a = sheet.patch.points[ia], &b = sheet.patch.points[ib], &c = sheet.patch.points[ic];
  const Vec3 across = cross(b - a, c - a);
  const auto part = [&](const Vec3& from, const Vec3& to) {
    return std::max(0.0, dot(cross(to - from, p - from), across));
  };
  return normalized(vector_of(sheet.normals[ia]) * part(b, c) +
                    vector_of(sheet.normals[ib]) * part(c, a) +
                    vector_of(sheet.normals[ic]) * part(a, b));
}

/// One surface's samples.
class Measurement {
 public:
  Measurement(const Sheet& sheet, const Surfaces& own, Around& other, const Question& question)
      : sheet_(sheet), other_(other), question_(question) {
    for (const auto& name : own.manifest().materials) ids_.push_back(other.id_of(name));
  }

  Findings run() {
    look_at_points();
    for (std::uint32_t t = 0; t < sheet_.patch.triangles.size(); ++t) look_at_triangle(t);
    return found_;
  }
  std::vector<double>& distances() { return distances_; }

 private:
  bool inside(const Vec3& p) const {
    const auto& [low, high] = question_.ground;
    return p.x >= low.x && p.x < high.x && p.y >= low.y && p.y < high.y;
  }

  /// The material of a point as the other bake numbers it; -1 where that has none of the name.
  int material_of(std::uint32_t point) const { return ids_[sheet_.materials[point]]; }

  /// With distances that are rounding and nothing else made 0.
  Around::Nearest nearest(const Vec3& p) {
    auto near = other_.nearest(p);
    const double least = 1e-9 * question_.spacing;
    if (near.distance2 < least * least) near.distance2 = 0;
    return near;
  }

  void look_at_points() {
    const auto& points = sheet_.patch.points;
    distances_.assign(points.size(), -1);
    changed_.assign(points.size(), false);
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      if (!inside(points[i])) continue;
      distances_[i] = Box::infinity;
      if (other_.empty()) continue;
      const auto near = nearest(points[i]);
      distances_[i] = std::sqrt(near.distance2);
      found_.largest2 = std::max(found_.largest2, near.distance2);
      if (!question_.attributes) continue;
      changed_[i] = has_changed(points[i], near, material_of(i));
      const Vec3 turned = normalized(vector_of(sheet_.normals[i])) -
                          normal_near(points[i], *near.sheet, near.triangle);
      found_.chord2 = std::max(found_.chord2, dot(turned, turned));
    }
  }

  void look_at_triangle(std::uint32_t triangle) {
    const auto& corners = sheet_.patch.triangles[triangle];
    const auto& points = sheet_.patch.points;
    const Vec3 &a = points[corners[0]], &b = points[corners[1]], &c = points[corners[2]];
    int samples = 3, counted = 0, changed = 0;
    double sum = 0;
    for (const auto corner : corners) {
      if (distances_[corner] < 0) continue;
      ++counted;
      if (!other_.empty()) sum += distances_[corner];
      changed += changed_[corner] ? 1 : 0;
    }
    lod::for_each_sample(a, b, c, question_.spacing, [&](const Vec3& p) {
      ++samples;
      if (!inside(p)) return;
      ++counted;
      if (other_.empty()) return;
      const auto near = nearest(p);
      found_.largest2 = std::max(found_.largest2, near.distance2);
      sum += std::sqrt(near.distance2);
      if (question_.attributes && has_changed(p, near, material_of(corners[0]))) ++changed;
    });
    const double share = 0.5 * length(cross(b - a, c - a)) / samples;
    found_.area += share * counted;
    found_.area_distance += share * sum;
    found_.changed_area += share * changed;
  }

  bool has_changed(const Vec3& p, const Around::Nearest& near, int material) {
    if (material < 0) return true;
    if (near.sheet->material(near.triangle) == material) return false;
    // A little farther than the nearest point, where triangles of two materials meet.
    const double reach =
        std::max(std::sqrt(near.distance2), question_.tolerance) + question_.spacing / 64;
    return !other_.has_material(p, reach, material);
  }

  const Sheet& sheet_;
  Around& other_;
  const Question& question_;
  std::vector<double> distances_;  // of the points
  std::vector<bool> changed_;      // their materials
  std::vector<int> ids_;           // of the other bake, by own material
  Findings found_;
};

}  // namespace

Around::Around(Surfaces& bake, const std::vector<plan::Key>& keys) : bake_(bake) {
  for (const auto& key : keys) parts_.push_back({key, bake.bounds(key), nullptr});
}

const Sheet& Around::open(Part& part) {
  if (!part.sheet) part.sheet = bake_.sheet(part.key);
  return *part.sheet;
}

void Around::ask(Part& part, const Vec3& p, Nearest& best) {
  const Sheet& sheet = open(part);
  const double d2 = sheet.buckets.beyond(p, 0, part.hint);
  if (d2 < best.distance2) best = {d2, &sheet, part.hint};
}

Around::Nearest Around::nearest(const Vec3& p) {
  const auto first = std::ranges::min_element(
      parts_, {}, [&](const Part& part) { return distance2(p, part.bounds); });
  Nearest best;
  ask(*first, p, best);
  for (auto part = parts_.begin(); part != parts_.end(); ++part) {
    if (part != first && distance2(p, part->bounds) < best.distance2) ask(*part, p, best);
  }
  return best;
}

int Around::id_of(const std::string& name) const {
  const auto& names = bake_.manifest().materials;
  const auto at = std::ranges::find(names, name);
  return at == names.end() ? -1 : static_cast<int>(at - names.begin());
}

bool Around::has_material(const Vec3& p, double reach, int id) {
  for (auto& part : parts_) {
    if (distance2(p, part.bounds) > reach * reach) continue;
    const Sheet& sheet = open(part);
    if (!sheet.present.contains(id)) continue;
    bool found = false;
    sheet.buckets.for_each_near(p, reach,
                                [&](std::uint32_t t) { found = found || sheet.material(t) == id; });
    if (found) return true;
  }
  return false;
}

void Findings::add(const Findings& other) {
  largest2 = std::max(largest2, other.largest2);
  chord2 = std::max(chord2, other.chord2);
  area += other.area;
  area_distance += other.area_distance;
  changed_area += other.changed_area;
}

double Findings::normal_degrees() const {
  // A chord of length c is seen under 2 asin(c/2); found by halving, without libm.
  const double half = std::sqrt(chord2) / 2;
  double low = 0, high = pi / 2;
  for (int i = 0; i < 60 && half > 0; ++i) {
    const double middle = 0.5 * (low + high);
    (bit_sin(middle) < half ? low : high) = middle;
  }
  return half > 0 ? 2 * high * (180 / pi) : 0;
}

Findings measure(const Sheet& sheet, const Surfaces& own, Around& other, const Question& question,
                 std::vector<double>* distances) {
  Measurement measurement(sheet, own, other, question);
  const auto found = measurement.run();
  if (distances != nullptr) *distances = std::move(measurement.distances());
  return found;
}

}  // namespace hoodoo::compare
