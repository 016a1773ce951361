#include "engine/tree/balls.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "engine/tree/ball_file.hpp"
#include "engine/tree/morton.hpp"

namespace hoodoo::tree {
namespace {

float down(double v) {
  const auto f = static_cast<float>(v);
  return static_cast<double>(f) <= v ? f
                                     : std::nextafter(f, -std::numeric_limits<float>::infinity());
}
float up(double v) { return -down(-v); }

/// Places of the balls along a Z-order curve.
std::vector<std::uint32_t> along_curve(const std::vector<Ball>& list) {
  Box box;
  for (const Ball& b : list) box.add(b.center);
  const MortonCurve curve(box);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  keys.reserve(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    keys.emplace_back(curve.at(list[i].center), static_cast<std::uint32_t>(i));
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> places;
  places.reserve(keys.size());
  for (const auto& [key, place] : keys) places.push_back(place);
  return places;
}

}  // namespace

struct Balls::Builder {
  Data& data;

  static Groups none() {
    constexpr float most = std::numeric_limits<float>::max();
    Groups g;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      g.low[axis].fill(most);
      g.high[axis].fill(-most);
    }
    g.radius.fill(0);
    return g;
  }

  void add(Groups& to, std::size_t slot, const Stored& b) const {
    const std::array centre{b.x, b.y, b.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      to.low[axis][slot] = std::min(to.low[axis][slot], down(centre[axis]));
      to.high[axis][slot] = std::max(to.high[axis][slot], up(centre[axis]));
    }
    to.radius[slot] = std::max(to.radius[slot], up(b.radius));
  }
  void add(Groups& to, std::size_t slot, const Groups& below) const {
    for (std::size_t i = 0; i < fan; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        to.low[axis][slot] = std::min(to.low[axis][slot], below.low[axis][i]);
        to.high[axis][slot] = std::max(to.high[axis][slot], below.high[axis][i]);
      }
      to.radius[slot] = std::max(to.radius[slot], below.radius[i]);
    }
  }

  void build() const {
    std::size_t slots = (data.balls.size() + fan - 1) / fan, total = 0;
    for (std::size_t n = slots; total == 0 || n > 1; total += n) n = (n + fan - 1) / fan;
    data.groups.reserve(total);
    data.levels.push_back(0);
    data.groups.resize((slots + fan - 1) / fan, none());
    for (std::size_t i = 0; i < data.balls.size(); ++i) {
      add(data.groups[i / fan / fan], i / fan % fan, data.balls[i]);
    }
    while (data.groups.size() - data.levels.back() > 1) {
      const std::size_t first = data.levels.back(), last = data.groups.size();
      data.levels.push_back(last);
      data.groups.resize(last + (last - first + fan - 1) / fan, none());
      for (std::size_t i = first; i < last; ++i) {
        add(data.groups[last + (i - first) / fan], (i - first) % fan, data.groups[i]);
      }
    }
  }
};

Balls::Balls(const std::vector<Ball>& list) {
  if (list.empty()) return;
  auto data = std::make_shared<Data>();
  data->balls.reserve(list.size());
  for (const auto place : along_curve(list)) {
    const Ball& b = list[place];
    data->balls.push_back({b.center.x, b.center.y, b.center.z, b.radius, b.energy, place});
  }
  Builder{*data}.build();
  data_ = std::move(data);
}

void BallDigest::add(const Ball& b) {
  const std::array numbers{b.center.x, b.center.y, b.center.z, b.radius,
                           static_cast<double>(b.energy)};
  hash_.add(std::as_bytes(std::span(numbers)));
}

std::size_t Balls::size() const {
  if (file_) return file_->size();
  return data_ ? data_->balls.size() : 0;
}

std::vector<Ball> Balls::list() const {
  std::vector<Ball> list(size());
  for_each([&](const Stored& b) { list[b.place] = b.ball(); });
  return list;
}

Digest Balls::digest() const {
  if (file_) return file_->digest();
  BallDigest digest;
  for (const Ball& ball : list()) digest.add(ball);
  return digest.finish();
}

Balls Balls::part(const Box& box, double stretch, double margin, double least) const {
  if (!file_) return *this;
  std::vector<Ball> list;
  for (const Stored& b : file_->near(box, stretch, margin, least)) list.push_back(b.ball());
  return Balls(list);
}

void Balls::for_each(const std::function<void(const Stored&)>& visit) const {
  if (file_) return file_->for_each(visit);
  if (!data_) return;
  for (const Stored& b : data_->balls) visit(b);
}

Box Balls::box(double stretch) const {
  Box all;
  for_each([&](const Stored& b) {
    const Vec3 c{b.x, b.y, b.z};
    all.add(Box{c, c}.grown(stretch * b.radius));
  });
  return all;
}

/// Groups are compared in single precision: with the box rounded outward, and with reaches that
/// grow by more than the comparison loses.
struct Balls::Search {
  const Data& data;
  const Box& box;
  double stretch, margin;
  std::vector<std::uint64_t> found{};  // place, then index: sorting them sorts by place
  std::size_t n = 0;                   // of those found; there is more room
  std::array<float, 3> low{}, high{};
  float reach_per_radius = 0, reach_more = 0;

  void run() {
    constexpr double most = std::numeric_limits<float>::max();
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = down(std::max(box.min[static_cast<int>(a)], -most));
      high[a] = up(std::min(box.max[static_cast<int>(a)], most));
    }
    reach_per_radius = up(stretch * (1 + 1e-6));
    reach_more = up(margin * (1 + 1e-6));
    groups(data.levels.size() - 1, 0);
    found.resize(n);
    sort();
  }

  /// One bit for each of the eight that can hold what is near.
  unsigned touched(const Groups& g) const {
    std::array<std::uint32_t, fan> apart{};
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t i = 0; i < fan; ++i) {
        // Differences, whose rounding is a part of the distance and not of the coordinates.
        const float reach = reach_per_radius * g.radius[i] + reach_more;
        apart[i] |= static_cast<std::uint32_t>(g.low[a][i] - high[a] > reach) |
                    static_cast<std::uint32_t>(low[a] - g.high[a][i] > reach);
      }
    }
    unsigned bits = 0;
    for (std::size_t i = 0; i < fan; ++i) bits |= (1U ^ apart[i]) << i;
    return bits;
  }

  void groups(std::size_t level, std::size_t index) {
    const std::size_t first = fan * index;
    const std::size_t slots = level == 0 ? (data.balls.size() + fan - 1) / fan
                                         : data.levels[level] - data.levels[level - 1];
    unsigned bits = touched(data.groups[data.levels[level] + index]);
    for (; bits != 0; bits &= bits - 1) {
      const std::size_t slot = first + static_cast<std::size_t>(std::countr_zero(bits));
      if (slot >= slots) return;
      level == 0 ? balls(slot) : groups(level - 1, slot);
    }
  }

  /// Without a branch that cannot be foreseen.
  void balls(std::size_t slot) {
    const std::size_t first = fan * slot, last = std::min(first + fan, data.balls.size());
    if (found.size() < n + fan) found.resize(2 * (n + fan));
    for (std::size_t i = first; i < last; ++i) {
      const Stored& b = data.balls[i];
      const double reach = stretch * b.radius + margin;
      found[n] = std::uint64_t{b.place} << 32 | i;
      n += near_square(b, box) <= reach * reach ? 1 : 0;
    }
  }

  /// By place: first into as many buckets as there are places, of equal width, which leaves little
  /// for an insertion sort to do.
  void sort() {
    constexpr std::size_t few = 1024;
    if (n < 2) return;
    if (n > few) return std::sort(found.begin(), found.end());
    const auto [least, most] = std::minmax_element(found.begin(), found.end());
    const std::uint64_t from = *least >> 32, range = (*most >> 32) - from + 1;
    const auto bucket = [&](std::uint64_t key) { return ((key >> 32) - from) * n / range; };
    std::array<std::uint16_t, few + 1> first;
    std::fill(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(n + 1), std::uint16_t{0});
    for (const auto key : found) ++first[bucket(key) + 1];
    for (std::size_t i = 1; i < n; ++i)
      first[i] = static_cast<std::uint16_t>(first[i] + first[i - 1]);
    std::array<std::uint64_t, few> sorted;
    for (const auto key : found) sorted[first[bucket(key)]++] = key;
    for (std::size_t i = 1; i < n; ++i) {
      const std::uint64_t key = sorted[i];
      std::size_t j = i;
      for (; j > 0 && sorted[j - 1] > key; --j) sorted[j] = sorted[j - 1];
      sorted[j] = key;
    }
    std::copy(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n), found.begin());
  }

  static double larger(double a, double b) { return a > b ? a : b; }

  /// Squares of the smallest and of the largest distance from the centre to points of the box.
  static double near_square(const Stored& b, const Box& box) {
    const double x = larger(0, larger(box.min.x - b.x, b.x - box.max.x));
    const double y = larger(0, larger(box.min.y - b.y, b.y - box.max.y));
    const double z = larger(0, larger(box.min.z - b.z, b.z - box.max.z));
    return x * x + y * y + z * z;
  }
  static double far_square(const Stored& b, const Box& box) {
    const double x = larger(b.x - box.min.x, box.max.x - b.x);
    const double y = larger(b.y - box.min.y, box.max.y - b.y);
    const double z = larger(b.z - box.min.z, box.max.z - b.z);
    return x * x + y * y + z * z;
  }
};

std::vector<Balls::Found> Balls::near(const Box& box, double stretch, double margin) const {
  std::vector<Found> found;
  assert(!file_);
  if (!data_) return found;
  Search search{*data_, box, stretch, margin};
  search.found.resize(128);
  search.run();
  found.reserve(search.found.size());
  for (const auto key : search.found) {
    const Stored& b = data_->balls[key & 0xffffffffU];
    found.push_back(
        {&b, std::sqrt(Search::near_square(b, box)), std::sqrt(Search::far_square(b, box))});
  }
  return found;
}

bool operator==(const Balls& a, const Balls& b) {
  if (a.data_ == b.data_ && a.file_ == b.file_) return true;
  if (a.size() != b.size()) return false;
  return a.file_ || b.file_ ? a.digest() == b.digest() : a.list() == b.list();
}

}  // namespace hoodoo::tree
