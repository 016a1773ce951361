#include "engine/tree/field.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

#include "engine/tree/body.hpp"
#include "engine/tree/dual.hpp"
#include "engine/tree/evaluate.hpp"
#include "engine/tree/region.hpp"
#include "engine/tree/rock.hpp"
#include "engine/tree/rows.hpp"

namespace hoodoo::tree {
namespace {

using D = Dual<float>;
using Row = std::array<float, batch_size>;

/// A batch of values with their gradients.
struct Slopes {
  Row v, x, y, z;
  Gradients spans(std::size_t n) { return {{x.data(), n}, {y.data(), n}, {z.data(), n}}; }
  D at(std::size_t i) const { return {v[i], x[i], y[i], z[i]}; }
  void put(std::size_t i, const D& d) {
    v[i] = d.v;
    x[i] = d.x;
    y[i] = d.y;
    z[i] = d.z;
  }
};

/// v in [0,1]; 0 and 1 keep their slopes, so that a step that adds nothing changes nothing. What is
/// no number, because a scene lies beyond single precision, is air.
template <class T>
T held(const T& v) {
  const T least = value_of(v) >= 0 ? v : T(0);
  return value_of(least) <= 1 ? least : T(1);
}
inline Interval held(const Interval& v) { return clamp(v, 0, 1); }

/// What an operation makes of F so far and its tree's value.
template <class T>
T apply(Operation operation, const T& f, const T& tree) {
  const T result = operation == Operation::blend        ? f + tree
                   : operation == Operation::carve      ? f - tree
                   : operation == Operation::unite      ? larger(f, tree)
                   : operation == Operation::difference ? smaller(f, constant<T>(1) - tree)
                   : operation == Operation::intersect  ? smaller(f, tree)
                                                        : tree;
  return held(result);
}

/// before + w (after - before): exactly `before` where w is 0 or nothing changed, `after` at 1.
template <class T>
T mixed(const T& before, const T& after, const T& w) {
  return value_of(w) == 1 ? after : before + w * (after - before);
}

struct CompiledStep {
  const Step* step;
  Compiled tree;
  const Region* region;  // null: weight 1 throughout the block
};

class BlockField final : public Field {
 public:
  BlockField(const Ground& ground, std::span<const dem::Window> windows, const Block& block)
      : ground_(&ground), origin_(block.origin), rock_(ground, block) {
    add_bodies(windows, block);
    for (const Step& step : ground.steps) add_step(step, block);
  }

  void values(const Points& at, std::span<float> out) const override {
    for_batches(at, [&](const Points& batch, std::size_t from) {
      const auto part = out.subspan(from, batch.size());
      run(batch, part, nullptr);
      for (float& v : part) v += 0.0F;
    });
  }

  std::size_t grid(const Grid& at, std::span<float> out, Columns* columns) const override {
    const bool narrow = at.x.size() <= Cube::side && at.y.size() <= Cube::side;
    const bool whole = at.y.size() == Cube::side && at.z.size() == Cube::side;
    alignas(64) std::array<float, Cube::size> f;
    std::size_t asked = 0;
    for_cubes(at, [&](const Cube& cube, const std::array<std::size_t, 4>& from) {
      Columns own;
      const auto [i0, j0, k0, nz] = from;
      const bool here = whole && cube.nx == Cube::side;
      const CubeValues values = here ? CubeValues(out.data() + i0 * batch_size, Cube::size) : f;
      asked += nz * run(cube, values, narrow && columns != nullptr ? *columns : own);
      for (std::size_t i = 0; i < cube.nx && !here; ++i) {
        for (std::size_t j = 0; j < cube.ny; ++j) {
          const float* row = f.data() + (Cube::side * i + j) * Cube::side;
          std::copy(row, row + nz,
                    out.data() + ((i0 + i) * at.y.size() + j0 + j) * at.z.size() + k0);
        }
      }
    });
    return asked;
  }

  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    for_batches(at, [&](const Points& batch, std::size_t from) {
      const std::size_t n = batch.size();
      Slopes f;
      run(batch, f);
      // + 0: no -0, whose sign would depend on what was pruned.
      for (std::size_t i = 0; i < n; ++i) {
        out[from + i] = f.v[i] + 0.0F;
        g.x[from + i] = f.x[i] + 0.0F;
        g.y[from + i] = f.y[i] + 0.0F;
        g.z[from + i] = f.z[i] + 0.0F;
      }
    });
  }

  void materials(const Points& at, std::span<int> out) const override {
    for_batches(at, [&](const Points& batch, std::size_t from) {
      const std::size_t n = batch.size();
      std::array<const CompiledStep*, batch_size> maker{};
      Row f;
      run(batch, {f.data(), n}, maker.data());
      rock_.materials(batch, out.subspan(from, n));
      for (std::size_t i = 0; i < n; ++i) {
        if (maker[i] != nullptr) out[from + i] = maker[i]->step->material;
      }
    });
  }

  std::optional<int> material() const override {
    const bool own = std::any_of(steps_.begin(), steps_.end(),
                                 [](const auto& s) { return s.step->material >= 0; });
    return own ? std::nullopt : rock_.material();
  }

  void resistances(const Points& at, std::span<float> out) const override {
    for_batches(at, [&](const Points& batch, std::size_t from) {
      rock_.resistances(batch, out.subspan(from, batch.size()));
    });
  }

  Interval bounds() const override { return bounds_; }

  const dem::Window* height_field() const override {
    return steps_.empty() && bodies_.size() == 1 ? bodies_[0].elevations() : nullptr;
  }

  std::vector<std::string> explain() const override {
    std::vector<std::string> lines;
    for (const BodyField& body : bodies_)
      lines.push_back(fmt::format("terrain {}", body.body().id));
    constexpr std::array names{"blend", "carve", "union", "difference", "intersect", "replace"};
    for (const CompiledStep& s : steps_) {
      const std::string& name = s.step->id.empty() ? s.step->where : s.step->id;
      lines.push_back(
          fmt::format("{} {}", names[static_cast<std::size_t>(s.step->operation)], name));
      if (s.tree.kernel) s.tree.kernel->explain(1, lines);
    }
    rock_.explain(lines);
    return lines;
  }

 private:
  template <class Use>
  static void for_batches(const Points& at, Use use) {
    for (std::size_t from = 0; from < at.size(); from += batch_size) {
      const std::size_t n = std::min(batch_size, at.size() - from);
      use(Points{at.x.subspan(from, n), at.y.subspan(from, n), at.z.subspan(from, n)}, from);
    }
  }

  /// Calls use(cube, {first i, first j, first k, number of k}) for the parts of a grid.
  template <class Use>
  static void for_cubes(const Grid& at, Use use) {
    static constexpr std::size_t side = Cube::side;
    const auto fill = [](std::array<float, side>& to, std::span<const float> all,
                         std::size_t from) {
      const std::size_t n = std::min(side, all.size() - from);
      for (std::size_t i = 0; i < side; ++i) to[i] = all[from + std::min(i, n - 1)];
      return n;
    };
    Cube cube;
    for (std::size_t i = 0; i < at.x.size(); i += side) {
      cube.nx = fill(cube.x, at.x, i);
      for (std::size_t j = 0; j < at.y.size(); j += side) {
        cube.ny = fill(cube.y, at.y, j);
        for (std::size_t k = 0; k < at.z.size(); k += side) {
          const std::size_t nz = fill(cube.z, at.z, k);
          use(cube, std::array{i, j, k, nz});
        }
      }
    }
  }

  /// Bodies without elevations, those that are 0 throughout the block, or below another, are left
  /// out.
  void add_bodies(std::span<const dem::Window> windows, const Block& block) {
    assert(windows.size() >= ground_->bodies.size());
    double least = 0;
    for (std::size_t i = 0; i < ground_->bodies.size(); ++i) {
      if (windows[i].empty()) continue;
      bodies_.emplace_back(ground_->bodies[i], windows[i], block);
      least = std::max(least, bodies_.back().bounds().low);
      bounds_ = max(bounds_, bodies_.back().bounds());
    }
    std::erase_if(bodies_, [&](const BodyField& body) {
      return body.bounds().high < least || body.bounds() == Interval{0, 0};
    });
  }

  void add_step(const Step& step, const Block& block) {
    const Region* region = step.region.get();
    if (region != nullptr) {
      const Interval w = region->weights(block.box);
      if (w.high <= 0) return;
      if (w.low >= 1) region = nullptr;
    }
    CompiledStep compiled{&step, compile(step.tree, block), region};
    if (!compiled.tree.kernel && !acts_by_zero(step.operation)) return;
    const Interval after =
        clamp(outward(apply(step.operation, bounds_, compiled.tree.bounds)), 0, 1);
    bounds_ = region != nullptr ? clamp(outward(hull(bounds_, after)), 0, 1) : after;
    steps_.push_back(std::move(compiled));
  }

  /// F; into `maker`, if given, the last step with a material of its own that changed F.
  void run(const Points& at, std::span<float> f, const CompiledStep** maker) const {
    const std::size_t n = at.size();
    Row tree, before;
    std::fill(f.begin(), f.end(), 0.0F);
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      bodies_[b].values(at, {tree.data(), n});
      for (std::size_t i = 0; i < n; ++i) f[i] = b == 0 ? tree[i] : larger(f[i], tree[i]);
    }
    for (const CompiledStep& s : steps_) {
      if (s.tree.kernel) {
        s.tree.kernel->values(at, {tree.data(), n});
      } else {
        tree.fill(0);
      }
      std::copy(f.begin(), f.end(), before.begin());
      for (std::size_t i = 0; i < n; ++i) f[i] = apply(s.step->operation, f[i], tree[i]);
      if (s.region != nullptr) {
        for (std::size_t i = 0; i < n; ++i) f[i] = mixed(before[i], f[i], weight(s, at, i).v);
      }
      if (maker == nullptr || s.step->material < 0) continue;
      for (std::size_t i = 0; i < n; ++i) {
        if (f[i] != before[i]) maker[i] = &s;
      }
    }
  }

  /// Returns at how many rows anything but one body's elevations was asked.
  std::size_t run(const Cube& at, CubeValues f, Columns& columns) const {
    const bool regional = std::any_of(steps_.begin(), steps_.end(),
                                      [](const auto& s) { return s.region != nullptr; });
    if (regional) {
      run_planes(at, f);
      return at.nx * at.ny;
    }
    alignas(64) std::array<float, Cube::size> tree;
    columns.bodies.resize(ground_->bodies.size());
    if (bodies_.empty()) std::fill(f.begin(), f.end(), 0.0F);
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      const auto place = static_cast<std::size_t>(&bodies_[b].body() - ground_->bodies.data());
      bodies_[b].cube(at, columns.bodies[place], b == 0 ? f : tree);
      if (b > 0) unite_rows(at.nx, f, tree);
    }
    AskedRows asked;
    const bool plain = bodies_.size() == 1 && bodies_[0].elevations() != nullptr;
    asked.fill(plain ? 0 : 1);
    for (const CompiledStep& s : steps_) {
      if (s.tree.kernel) {
        s.tree.kernel->cube(at, tree, asked);
      } else {
        tree.fill(0);
      }
      if (acts_by_zero(s.step->operation)) asked.fill(1);
      apply_rows(s.step->operation, at.nx, f, tree);
    }
    return count_asked(at, asked);
  }

  static std::size_t count_asked(const Cube& at, const AskedRows& asked) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < at.nx; ++i) {
      for (std::size_t j = 0; j < at.ny; ++j) n += asked[Cube::side * i + j] != 0 ? 1 : 0;
    }
    return n;
  }

  /// Plane by plane, as batches.
  void run_planes(const Cube& at, CubeValues f) const {
    constexpr std::size_t side = Cube::side;
    Row x, y, z;
    for (std::size_t n = 0; n < batch_size; ++n) {
      y[n] = at.y[n / side];
      z[n] = at.z[n % side];
    }
    for (std::size_t i = 0; i < at.nx; ++i) {
      x.fill(at.x[i]);
      const auto plane = f.subspan(batch_size * i, batch_size);
      run({x, y, z}, plane, nullptr);
      for (float& v : plane) v += 0.0F;
    }
  }

  void run(const Points& at, Slopes& f) const {
    const std::size_t n = at.size();
    Slopes tree;
    for (std::size_t i = 0; i < n; ++i) f.put(i, D());
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      bodies_[b].gradients(at, {tree.v.data(), n}, tree.spans(n));
      for (std::size_t i = 0; i < n; ++i)
        f.put(i, b == 0 ? tree.at(i) : larger(f.at(i), tree.at(i)));
    }
    for (const CompiledStep& s : steps_) {
      if (s.tree.kernel) {
        s.tree.kernel->gradients(at, {tree.v.data(), n}, tree.spans(n));
      } else {
        for (std::size_t i = 0; i < n; ++i) tree.put(i, D());
      }
      for (std::size_t i = 0; i < n; ++i) {
        const D before = f.at(i), after = apply(s.step->operation, before, tree.at(i));
        f.put(i, s.region != nullptr ? mixed(before, after, weight(s, at, i)) : after);
      }
    }
  }

  D weight(const CompiledStep& s, const Points& at, std::size_t i) const {
    const Vec3 p = origin_ + Vec3{static_cast<double>(at.x[i]), static_cast<double>(at.y[i]),
                                  static_cast<double>(at.z[i])};
    const Weight w = s.region->weight(p);
    return {static_cast<float>(w.w), static_cast<float>(w.gradient.x),
            static_cast<float>(w.gradient.y), static_cast<float>(w.gradient.z)};
  }

  const Ground* ground_;
  Vec3 origin_;
  std::vector<BodyField> bodies_;
  std::vector<CompiledStep> steps_;
  RockField rock_;
  Interval bounds_{0, 0};
};

}  // namespace

std::unique_ptr<const Field> compile(const Ground& ground, std::span<const dem::Window> windows,
                                     const Vec3& origin, const Box& box) {
  return std::make_unique<BlockField>(ground, windows, Block{origin, box});
}

}  // namespace hoodoo::tree
