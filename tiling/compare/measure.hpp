#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/box.hpp"
#include "tiling/compare/surfaces.hpp"

namespace hoodoo::compare {

/// One bake's surface in and around a region.
class Around {
 public:
  /// Tiles are read when a point comes near enough for them to matter.
  Around(Surfaces& bake, const std::vector<plan::Key>& keys);

  bool empty() const { return parts_.empty(); }
  struct Nearest {
    double distance2 = Box::infinity;
    const Sheet* sheet = nullptr;
    std::uint32_t triangle = 0;
  };
  /// There must be tiles.
  Nearest nearest(const Vec3& p);
  /// The id of a material in this bake; -1 where it has none of that name.
  int id_of(const std::string& name) const;
  /// Some triangle of the material lies within `reach` of `p`.
  bool has_material(const Vec3& p, double reach, int id);

 private:
  struct Part {
    plan::Key key;
    Box bounds;
    std::shared_ptr<const Sheet> sheet;
    std::uint32_t hint = 0;
  };
  const Sheet& open(Part& part);
  void ask(Part& part, const Vec3& p, Nearest& best);

  Surfaces& bake_;
  std::vector<Part> parts_;
};

/// What is asked of a surface's samples.
struct Question {
  double spacing = 1;              // of the samples [m]
  double tolerance = 0;            // [m]
  bool attributes = true;          // normals and materials, too
  Box ground = Box::everywhere();  // samples elsewhere are left out; half-open
};

/// What samples of one surface, or of several, found out about another one.
struct Findings {
  double largest2 = 0;       // squared distance [m^2]
  double chord2 = 0;         // squared length of the largest difference of unit normals
  double area = 0;           // [m^2]
  double area_distance = 0;  // area times distance [m^3]
  double changed_area = 0;   // of another material [m^2]

  void add(const Findings& other);
  double mean() const { return area > 0 ? area_distance / area : 0; }
  double changed_share() const { return area > 0 ? changed_area / area : 0; }
  double normal_degrees() const;
};

/// Compares a surface of `own` with that of the other bake. `distances`, where given, gets that of
/// each point [m]: infinite where there is nothing to be near to, negative off the ground.
Findings measure(const Sheet& sheet, const Surfaces& own, Around& other, const Question& question,
                 std::vector<double>* distances = nullptr);

}  // namespace hoodoo::compare
