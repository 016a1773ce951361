#pragma once
#include "engine/base/error.hpp"
#include "engine/tree/combine.hpp"

namespace hoodoo::tree {

/// The child itself, under a name by which a material is bound to the place where it prevails:
/// where the child, seen through what bends and moves it in the tree above, has at least `level` of
/// its peak. At the default of 1/2 that is the stated size of a primitive.
struct Stratum {
  static constexpr std::string_view type = "stratum";
  static constexpr std::string_view doc =
      "The child itself, under a name to which \"materials\" can bind a rock.";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr Family family = Family::geology;
  static constexpr std::array slots{Slot{"child", "What is named.", 1, 1, false}};
  static constexpr Pick pick = Pick::none;
  static constexpr bool adds = false;

  std::string name;
  double level = 0.5;

  static constexpr auto fields() {
    return std::tuple{
        Text<Stratum>{"name", &Stratum::name, required, "What a material's \"stratum\" says."},
        Number<Stratum>{"level", &Stratum::level, "1", within(0.001, 1), 0.5,
                        "The stratum is where the child has this part of its peak or more."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    if (name.empty()) problems.push_back({where + "/name", "must not be empty"});
  }
  Support support(std::span<const Support> children) const { return children[0]; }

  template <class T>
  T first(const T& a) const {
    return a;
  }
  template <class T>
  T join(const T& a, const T&) const {
    return a;
  }
  template <class T>
  T last(const T& a) const {
    return a;
  }
  friend bool operator==(const Stratum&, const Stratum&) = default;
};

}  // namespace hoodoo::tree
