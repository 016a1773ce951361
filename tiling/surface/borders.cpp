#include "tiling/surface/borders.hpp"

#include "tiling/surface/qef.hpp"
#include "tiling/surface/snap.hpp"

namespace hoodoo::surface {

using volume::Index;

namespace {

Index corner(const Face& face, int k) {
  Index p = face.low;
  p[next_axis(face.axis)] += k == 1 || k == 2 ? 1 : 0;
  p[last_axis(face.axis)] += k >= 2 ? 1 : 0;
  return p;
}

/// Edge k of a face: its crossing, in the frame of the face.
Line2 line_of(const volume::Volume& volume, const Face& face, int k) {
  const std::size_t u = next_axis(face.axis), v = last_axis(face.axis);
  const std::size_t along = k % 2 == 0 ? u : v;
  const Index low = corner(face, k == 0 || k == 3 ? 0 : k == 1 ? 1 : 3);
  const auto& crossing = volume.crossing(static_cast<int>(along), low);
  const Vec3 normal{crossing.normal.x, crossing.normal.y, crossing.normal.z};
  Line2 line{{static_cast<double>(low[u] - face.low[u]), static_cast<double>(low[v] - face.low[v])},
             {normal[static_cast<int>(u)], normal[static_cast<int>(v)]}};
  line.point[along == u ? 0 : 1] = static_cast<double>(crossing.t);
  return line;
}

}  // namespace

std::uint8_t Borders::planes_at(const Index& p, std::size_t axis) const {
  unsigned bits = 0;
  if (p[axis] == volume_.low()[axis]) bits |= 1U << (2 * axis);
  if (p[axis] == volume_.high()[axis]) bits |= 2U << (2 * axis);
  return static_cast<std::uint8_t>(bits);
}

std::uint64_t Borders::key(const Face& face) const {
  std::uint64_t key = face.axis;
  for (std::size_t d = 0; d < 3; ++d) {
    key = key << 20 | static_cast<std::uint64_t>(face.low[d] - volume_.low()[d]);
  }
  return key;
}

FaceCase Borders::case_of(const Face& face) const {
  unsigned corners = 0;
  for (int k = 0; k < 4; ++k) corners |= (volume_.solid(corner(face, k)) ? 1U : 0U) << k;
  return face_case(corners);
}

std::uint32_t Borders::face_vertex(const Face& face, int k, std::uint8_t marks) {
  const auto pairs = case_of(face);
  const auto [found, is_new] = first_vertex_.try_emplace(key(face), next());
  if (is_new) {
    add_segments(face, pairs, static_cast<std::uint8_t>(marks | planes_at(face.low, face.axis)));
  }
  const bool second =
      pairs.count == 2 && (pairs.segments[1].first == k || pairs.segments[1].second == k);
  return found->second + (second ? 1U : 0U);
}

void Borders::add_segments(const Face& face, const FaceCase& pairs, std::uint8_t planes) {
  std::array<std::array<std::int32_t, 2>, 2> taken;
  for (std::size_t i = 0; i < static_cast<std::size_t>(pairs.count); ++i) {
    const std::array<Line2, 2> lines{line_of(volume_, face, pairs.segments[i].first),
                                     line_of(volume_, face, pairs.segments[i].second)};
    const std::array<double, 2> mean{0.5 * (lines[0].point[0] + lines[1].point[0]),
                                     0.5 * (lines[0].point[1] + lines[1].point[1])};
    const auto best = minimise(lines, mean);
    taken[i] = free_point<2>({snap(mean[0] + best[0], units_), snap(mean[1] + best[1], units_)},
                             std::span(taken).first(i), mean, units_);
    std::array<std::int32_t, 3> steps{};
    steps[next_axis(face.axis)] = taken[i][0];
    steps[last_axis(face.axis)] = taken[i][1];
    append(face.low, steps, planes);
  }
}

std::uint32_t Borders::crossing_vertex(int axis, const Index& low, std::uint8_t marks) {
  const auto a = static_cast<std::size_t>(axis);
  std::array<std::int32_t, 3> steps{};
  steps[a] = snap(static_cast<double>(volume_.crossing(axis, low).t), units_);
  const auto planes = planes_at(low, next_axis(a)) | planes_at(low, last_axis(a)) | marks;
  append(low, steps, static_cast<std::uint8_t>(planes));
  return next() - 1;
}

void Borders::append(const Index& low, const std::array<std::int32_t, 3>& steps,
                     std::uint8_t planes) {
  auto point = steps;
  for (std::size_t d = 0; d < 3; ++d) {
    point[d] += static_cast<std::int32_t>(low[d] - volume_.low()[d]) * units_;
  }
  out_.points.push_back(point);
  out_.planes.push_back(planes);
}

}  // namespace hoodoo::surface
