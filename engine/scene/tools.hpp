#pragma once
#include <variant>

#include "engine/generator/generators.hpp"
#include "engine/scene/brushes.hpp"

namespace hoodoo::scene {

using generator::AnyGenerator;

template <class A, class B>
struct Joined;
template <class... A, class... B>
struct Joined<std::variant<A...>, std::variant<B...>> {
  using Type = std::variant<A..., B...>;
};

/// What an operation with a "type" may be: a brush, which builds one tree, or a generator, which
/// looks at the scene so far and grows any number.
using AnyTool = Joined<AnyBrush, AnyGenerator>::Type;

template <class T>
concept Brush = requires(const T& tool) {
  tool.build();
};

}  // namespace hoodoo::scene
