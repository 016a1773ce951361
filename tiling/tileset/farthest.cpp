#include "tiling/tileset/farthest.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tiling/lod/buckets.hpp"

namespace hoodoo::tileset {
namespace {

using Corners = std::array<Vec3, 3>;

class Search {
 public:
  Search(const Patch& to, double side, double more, double least)
      : to_(to),
        buckets_(to.points, to.triangles, side),
        more_(more / 2),
        worst_(std::max(least - more_, more_)) {}

  /// The triangle that answered: `p` is not farther from it than the farthest so far.
  std::uint32_t look(const Vec3& p) {
    worst_ = std::max(worst_, std::sqrt(buckets_.beyond(p, worst_ * worst_, hint_)));
    return hint_;
  }

  void look(const Corners& piece) {
    const Vec3 middle = (piece[0] + piece[1] + piece[2]) * (1.0 / 3);
    double radius2 = 0;
    for (const auto& corner : piece) {
      radius2 = std::max(radius2, dot(corner - middle, corner - middle));
    }
    if (radius2 <= more_ * more_) {
      look(middle);
      return;
    }
    const double near = worst_ + more_ - std::sqrt(radius2);
    if (near > 0) {
      const double found2 = buckets_.beyond(middle, near * near, hint_);
      if (found2 <= near * near) return;
      worst_ = std::max(worst_, std::sqrt(found2));
    }
    if (!all_near(piece)) halve(piece);
  }

  double result() const { return worst_ + more_; }

 private:
  /// The triangle found last is near all of the piece.
  bool all_near(const Corners& piece) const {
    const auto& nearest = to_.triangles[hint_];
    const Vec3 &a = to_.points[nearest[0]], &b = to_.points[nearest[1]],
               &c = to_.points[nearest[2]];
    const double most = worst_ + more_;
    return std::ranges::all_of(
        piece, [&](const Vec3& p) { return lod::distance2(p, a, b, c) <= most * most; });
  }

  /// Across the longest edge.
  void halve(const Corners& piece) {
    std::size_t longest = 0;
    double most = -1;
    for (std::size_t k = 0; k < 3; ++k) {
      const double edge = length(piece[(k + 1) % 3] - piece[k]);
      if (edge > most) {
        most = edge;
        longest = k;
      }
    }
    const Vec3 &a = piece[longest], &b = piece[(longest + 1) % 3], &c = piece[(longest + 2) % 3];
    const Vec3 middle = (a + b) * 0.5;
    look(Corners{a, middle, c});
    look(Corners{middle, b, c});
  }

  const Patch& to_;
  const lod::Buckets buckets_;
  const double more_;
  double worst_;  // not less than `more_`: on level ground all there is to find is rounding
  std::uint32_t hint_ = 0;
};

}  // namespace

double farthest(const Patch& from, const Patch& to, double side, double more, double least) {
  Search search(to, side, more, least);
  // Corners first: what they find makes most pieces answer at once.
  constexpr std::uint32_t unseen = ~0U;
  std::vector<std::uint32_t> nearest(from.points.size(), unseen);
  for (const auto& triangle : from.triangles) {
    for (const auto corner : triangle) {
      if (nearest[corner] == unseen) nearest[corner] = search.look(from.points[corner]);
    }
  }
  for (const auto& [a, b, c] : from.triangles) {
    // Corners near one triangle, which is convex: all between them is as near.
    if (nearest[a] == nearest[b] && nearest[b] == nearest[c]) continue;
    search.look(Corners{from.points[a], from.points[b], from.points[c]});
  }
  return search.result();
}

}  // namespace hoodoo::tileset
