#pragma once
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "engine/tree/dual.hpp"
#include "engine/tree/evaluate.hpp"
#include "engine/tree/node.hpp"

/// What the kernels and prunings of composite nodes share.
namespace hoodoo::tree {

/// 0 everywhere: an empty blend.
Node nothing();
bool is_nothing(const Node& node);

/// Support of each.
std::vector<Support> supports(const std::vector<Node>& trees);

/// Whether a thing of this influence matters to `compile` in any block inside `reach`.
bool reaches(const Box& influence, const Box& reach);

/// A batch of values with their gradients.
struct Slopes {
  std::array<float, batch_size> v, x, y, z;
  std::span<float> values(std::size_t n) { return {v.data(), n}; }
  Gradients spans(std::size_t n) { return {{x.data(), n}, {y.data(), n}, {z.data(), n}}; }
  Dual<float> at(std::size_t i) const { return {v[i], x[i], y[i], z[i]}; }
};

/// A kernel's values; 0 without one.
inline void put_values(const Kernel* kernel, const Points& at, std::span<float> out) {
  if (kernel != nullptr) return kernel->values(at, out);
  std::fill(out.begin(), out.end(), 0.0F);
}
inline void put_gradients(const Kernel* kernel, const Points& at, std::span<float> out,
                          const Gradients& g) {
  if (kernel != nullptr) return kernel->gradients(at, out, g);
  for (const auto& part : {out, g.x, g.y, g.z}) std::fill(part.begin(), part.end(), 0.0F);
}
inline void put(const Dual<float>& f, std::size_t i, std::span<float> out, const Gradients& g) {
  out[i] = f.v;
  g.x[i] = f.x;
  g.y[i] = f.y;
  g.z[i] = f.z;
}

/// A line of Kernel::explain.
inline std::string explained(int depth, std::string_view type) {
  return std::string(static_cast<std::size_t>(2 * depth), ' ') + std::string(type);
}

}  // namespace hoodoo::tree
