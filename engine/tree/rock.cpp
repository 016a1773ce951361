#include "engine/tree/rock.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace hoodoo::tree {
namespace {

using Row = std::array<float, batch_size>;

}  // namespace

RockField::RockField(const Ground& ground, const Block& block) : ground_(&ground) {
  if (ground.geology) rho_ = compile(*ground.geology, block);
  for (const Seam& seam : ground.seams) {
    Compiled tree = compile(seam.tree, block);
    if (tree.kernel && tree.bounds.high >= 0.5) {
      seams_.push_back({seam.material, std::move(tree.kernel)});
    }
  }
}

void RockField::resistances(const Points& at, std::span<float> out) const {
  if (!ground_->geology) {
    std::fill(out.begin(), out.end(), 0.5F);
  } else if (rho_.kernel) {
    rho_.kernel->values(at, out);
    // + 0: no -0. What is no number, because a scene lies beyond single precision, is 0.
    for (float& v : out) v = (v >= 0 ? std::min(v, 1.0F) : 0.0F) + 0.0F;
  } else {
    std::fill(out.begin(), out.end(), 0.0F);
  }
}

void RockField::materials(const Points& at, std::span<int> out) const {
  Row rho;
  resistances(at, {rho.data(), at.size()});
  for (std::size_t i = 0; i < at.size(); ++i) out[i] = material_of(static_cast<double>(rho[i]));
  bind_seams(at, out);
}

std::optional<int> RockField::material() const {
  if (!seams_.empty() || rho_.kernel) return std::nullopt;
  return material_of(ground_->geology ? 0 : 0.5);
}

/// The first seam that holds a point is bound last.
void RockField::bind_seams(const Points& at, std::span<int> out) const {
  Row tree;
  for (auto seam = seams_.rbegin(); seam != seams_.rend(); ++seam) {
    seam->kernel->values(at, {tree.data(), at.size()});
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (tree[i] >= 0.5F) out[i] = seam->material;
    }
  }
}

/// Of the materials without a stratum, the first whose range holds rho (half-open, but the last
/// closes at its high end), else the nearest.
int RockField::material_of(double rho) const {
  const auto& all = ground_->materials;
  const auto last =
      std::find_if(all.rbegin(), all.rend(), [](const Material& m) { return m.stratum.empty(); });
  std::size_t best = 0;
  double gap = Box::infinity;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i].stratum.empty()) continue;
    const bool closed = last != all.rend() && &all[i] == &*last && rho == all[i].high;
    if (rho >= all[i].low && (rho < all[i].high || closed)) return static_cast<int>(i);
    const double away = rho < all[i].low ? all[i].low - rho : rho - all[i].high;
    if (away < gap) {
      gap = away;
      best = i;
    }
  }
  return static_cast<int>(best);
}

void RockField::explain(std::vector<std::string>& lines) const {
  if (rho_.kernel) {
    lines.emplace_back("geology");
    rho_.kernel->explain(1, lines);
  }
}

}  // namespace hoodoo::tree
