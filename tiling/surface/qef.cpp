#include "tiling/surface/qef.hpp"

#include <algorithm>
#include <cmath>

namespace hoodoo::surface {
namespace {

constexpr double least_normal = 1e-6;  // of a normal's part in a face

/// A symmetric 3 x 3 matrix.
struct Symmetric {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  Vec3 operator*(const Vec3& v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z,
            xz * v.x + yz * v.y + zz * v.z};
  }
  void add(const Vec3& n) {
    xx += n.x * n.x, yy += n.y * n.y, zz += n.z * n.z;
    xy += n.x * n.y, xz += n.x * n.z, yz += n.y * n.z;
  }
  double trace() const { return xx + yy + zz; }
};

/// Turns the plane of two axes so that their common entry vanishes. `pr` and `qr` are the entries
/// of both with the third axis; `p` and `q` the columns of the eigenvectors so far.
/// Source: Golub, Van Loan 1996, Matrix Computations, section 8.4.
void rotate(double& pp, double& qq, double& pq, double& pr, double& qr, Vec3& p, Vec3& q) {
  if (pq == 0) return;
  const double theta = (qq - pp) / (2 * pq);
  const double t = (theta >= 0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1));
  const double c = 1 / std::sqrt(t * t + 1), s = t * c;
  pp -= t * pq;
  qq += t * pq;
  pq = 0;
  const double old_pr = pr;
  pr = c * pr - s * qr;
  qr = s * old_pr + c * qr;
  const Vec3 old_p = p;
  p = c * p - s * q;
  q = s * old_p + c * q;
}

/// Pseudo-inverse of `m` times `b` by Jacobi's method.
Vec3 solve(Symmetric m, const Vec3& b) {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  const double small = 1e-20 * m.trace() * m.trace();
  for (int sweep = 0; sweep < 8; ++sweep) {
    if (m.xy * m.xy + m.xz * m.xz + m.yz * m.yz <= small) break;
    rotate(m.xx, m.yy, m.xy, m.xz, m.yz, x, y);
    rotate(m.xx, m.zz, m.xz, m.xy, m.yz, x, z);
    rotate(m.yy, m.zz, m.yz, m.xy, m.xz, y, z);
  }
  const double least = least_eigenvalue * std::max({m.xx, m.yy, m.zz});
  Vec3 result;
  if (m.xx > least) result = result + x * (dot(x, b) / m.xx);
  if (m.yy > least) result = result + y * (dot(y, b) / m.yy);
  if (m.zz > least) result = result + z * (dot(z, b) / m.zz);
  return result;
}

}  // namespace

Vec3 mean_point(std::span<const Plane3> planes) {
  Vec3 sum;
  for (const auto& plane : planes) sum = sum + plane.point;
  return sum * (1 / static_cast<double>(planes.size()));
}

Vec3 minimise(std::span<const Plane3> planes, const Vec3& mean) {
  Symmetric m;
  Vec3 b, direction;
  for (const auto& [point, normal] : planes) {
    m.add(normal);
    b = b + normal * dot(normal, point - mean);
    direction = direction + normal;
  }
  // The largest eigenvalue is at least the Rayleigh quotient of the mean normal, the other two
  // together at most the rest of the trace. Where that rest is small one direction alone counts,
  // and the power method gives a digit of it per step.
  const double squared = dot(direction, direction);
  const double rayleigh = dot(direction, m * direction);
  if (squared > 0 && m.trace() * squared - rayleigh < least_eigenvalue * rayleigh) {
    const Vec3 v = m * (m * (m * direction));
    return v * (dot(v, b) / dot(v, m * v));
  }
  return solve(m, b);
}

std::array<double, 2> minimise(const std::array<Line2, 2>& lines,
                               const std::array<double, 2>& mean) {
  std::array<std::array<double, 2>, 2> n{};
  std::array<double, 2> r{};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& [point, normal] = lines[i];
    const double l = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1]);
    if (l < least_normal) continue;
    n[i] = {normal[0] / l, normal[1] / l};
    r[i] = n[i][0] * (point[0] - mean[0]) + n[i][1] * (point[1] - mean[1]);
  }
  // Two unit normals have the eigenvalues 1 + |cos| and 1 - |cos| of the angle between them, and
  // the eigenvector of the larger is their sum or difference.
  const double cosine = n[0][0] * n[1][0] + n[0][1] * n[1][1];
  const double area = n[0][0] * n[1][1] - n[0][1] * n[1][0];
  if (area != 0 && 1 - std::abs(cosine) > least_eigenvalue * (1 + std::abs(cosine))) {
    return {(r[0] * n[1][1] - r[1] * n[0][1]) / area, (n[0][0] * r[1] - n[1][0] * r[0]) / area};
  }
  const double sign = cosine >= 0 ? 1 : -1;
  const std::array<double, 2> v{n[0][0] + sign * n[1][0], n[0][1] + sign * n[1][1]};
  double above = 0, below = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const double along = v[0] * n[i][0] + v[1] * n[i][1];
    above += along * r[i];
    below += along * along;
  }
  if (!(below > 0)) return {0, 0};
  return {above / below * v[0], above / below * v[1]};
}

}  // namespace hoodoo::surface
