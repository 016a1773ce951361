#include "engine/generator/geology.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/error.hpp"
#include "engine/base/random.hpp"
#include "engine/tree/polygon.hpp"

namespace hoodoo::generator {
namespace {

/// Side of a block. Single precision still tells points a 10^5th of the spacing apart.
constexpr double block_spacings = 128;
/// Kept at once; beyond that all are forgotten and compiled again.
constexpr std::size_t most_blocks = 4096;
constexpr std::size_t most_squares = 1024;
/// Points that are asked for at once.
constexpr std::size_t batch = 16;

}  // namespace

std::size_t Geology::Hash::operator()(const Key& key) const {
  return static_cast<std::size_t>(random_bits(static_cast<std::uint64_t>(key[0]), key[1], key[2]));
}

Geology::Geology(const Site& site) : site_(site), side_(block_spacings * site.spacing()) {
  rock_.geology = site.ground().geology;
  rock_.materials = site.ground().materials;
}

const tree::Field& Geology::block(const Key& key) {
  if (last_ != nullptr && key == last_key_) return *last_;
  if (site_.spend().stop.stop_requested()) throw Error(Fault::cancelled, "", "cancelled");
  if (blocks_.size() >= most_blocks && !blocks_.contains(key)) blocks_.clear();
  auto& field = blocks_[key];
  if (!field) {
    const Vec3 origin{static_cast<double>(key[0]) * side_, static_cast<double>(key[1]) * side_,
                      static_cast<double>(key[2]) * side_};
    field = tree::compile(rock_, {}, origin, {origin, origin + Vec3{side_, side_, side_}});
  }
  last_key_ = key;
  last_ = field.get();
  return *field;
}

void Geology::resistances(std::span<const Vec3> at, std::span<float> out) {
  const auto key_of = [&](const Vec3& p) {
    const auto whole = [&](double v) { return static_cast<std::int64_t>(std::floor(v / side_)); };
    return Key{whole(p.x), whole(p.y), whole(p.z)};
  };
  std::array<float, batch> x, y, z;
  for (std::size_t from = 0; from < at.size();) {
    const auto key = key_of(at[from]);
    const Vec3 origin{static_cast<double>(key[0]) * side_, static_cast<double>(key[1]) * side_,
                      static_cast<double>(key[2]) * side_};
    std::size_t n = 0;
    for (; n < batch && from + n < at.size() && key_of(at[from + n]) == key; ++n) {
      const Vec3 p = at[from + n] - origin;
      x[n] = static_cast<float>(p.x);
      y[n] = static_cast<float>(p.y);
      z[n] = static_cast<float>(p.z);
    }
    const tree::Points points{{x.data(), n}, {y.data(), n}, {z.data(), n}};
    block(key).resistances(points, out.subspan(from, n));
    from += n;
  }
}

std::size_t Heights::Hash::operator()(const Key& key) const {
  return static_cast<std::size_t>(random_bits(static_cast<std::uint64_t>(key[0]), key[1]));
}

Heights::Heights(const Site& site) : site_(site), side_(block_spacings * site.spacing()) {}

std::optional<double> Heights::at(double x, double y) {
  const auto whole = [&](double v) { return static_cast<std::int64_t>(std::floor(v / side_)); };
  const Key key{whole(x), whole(y)};
  if (squares_.size() >= most_squares && !squares_.contains(key)) squares_.clear();
  const auto [found, fresh] = squares_.try_emplace(key);
  if (fresh) {
    const double x0 = static_cast<double>(key[0]) * side_, y0 = static_cast<double>(key[1]) * side_;
    found->second = site_.windows({{x0, y0, 0}, {x0 + side_, y0 + side_, 0}});
  }
  for (std::size_t i = 0; i < found->second.size(); ++i) {
    const auto& body = site_.ground().bodies[i];
    const auto& window = found->second[i];
    if (body.inverted || window.empty() || !window.valid(x, y)) continue;
    if (!body.domain.empty() && tree::edge_distance(body.domain, x, y).d < 0) continue;
    return window.height(x, y) + body.offset;
  }
  return std::nullopt;
}

}  // namespace hoodoo::generator
