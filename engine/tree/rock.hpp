#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/tree/evaluate.hpp"
#include "engine/tree/ground.hpp"

namespace hoodoo::tree {

/// The geology of a ground compiled for one block: resistances, and the materials they make.
class RockField {
 public:
  RockField(const Ground& ground, const Block& block);

  /// rho in [0,1] of at most batch_size points; 1/2 without a geology.
  void resistances(const Points& at, std::span<float> out) const;
  /// By stratum, else by resistance. At most batch_size points.
  void materials(const Points& at, std::span<int> out) const;
  /// That of every point, where one is known to be.
  std::optional<int> material() const;
  void explain(std::vector<std::string>& lines) const;

 private:
  struct CompiledSeam {
    int material;
    std::unique_ptr<const Kernel> kernel;
  };
  int material_of(double rho) const;
  void bind_seams(const Points& at, std::span<int> out) const;

  const Ground* ground_;
  Compiled rho_;
  std::vector<CompiledSeam> seams_;
};

}  // namespace hoodoo::tree
