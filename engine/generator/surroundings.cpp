#include "engine/generator/surroundings.hpp"

#include <bit>

#include "engine/base/random.hpp"

namespace hoodoo::generator {

Site::Value Surroundings::at(const Vec3& p) const {
  const Vec3 d = p - box_.min;
  const auto x = static_cast<float>(d.x), y = static_cast<float>(d.y), z = static_cast<float>(d.z);
  const tree::Points point{{&x, 1}, {&y, 1}, {&z, 1}};
  float f = 0, gx = 0, gy = 0, gz = 0, rho = 0;
  block_.field->gradients(point, {&f, 1}, {{&gx, 1}, {&gy, 1}, {&gz, 1}});
  block_.field->resistances(point, {&rho, 1});
  return {f, {static_cast<double>(gx), static_cast<double>(gy), static_cast<double>(gz)}, rho};
}

bool Surroundings::solid(const Vec3& p) const {
  const Vec3 d = p - box_.min;
  const auto x = static_cast<float>(d.x), y = static_cast<float>(d.y), z = static_cast<float>(d.z);
  float f = 0;
  block_.field->values({{&x, 1}, {&y, 1}, {&z, 1}}, {&f, 1});
  return f > 0.5F;
}

std::uint64_t key_of_place(std::uint64_t seed, const Vec3& p) {
  return random_bits(seed, std::bit_cast<std::uint64_t>(p.x), std::bit_cast<std::uint64_t>(p.y),
                     std::bit_cast<std::uint64_t>(p.z));
}

}  // namespace hoodoo::generator
