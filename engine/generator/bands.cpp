#include "engine/generator/bands.hpp"

#include <fmt/format.h>

#include <utility>

#include "engine/base/random.hpp"

namespace hoodoo::generator {
namespace {

constexpr double long_as = 20;  // a band, in thicknesses
constexpr double gain = 1.7;    // turbulence seldom comes near its ends

}  // namespace

tree::Node banded(const std::optional<tree::Node>& geology, const Bands& bands,
                  std::uint64_t seed) {
  tree::Node own{tree::Expression{}, {}};
  std::get<tree::Expression>(own.value).formula = "0.5";
  if (geology) own = *geology;
  if (bands.contrast == 0) return own;
  tree::Expression layers;
  layers.formula =
      fmt::format("contrast * (fbm(x / long, y / long, z / thick, {}) - 0.5)", bands.octaves);
  layers.parameters = {{"contrast", gain * bands.contrast},
                       {"long", long_as * bands.thickness},
                       {"thick", bands.thickness}};
  layers.seed = static_cast<std::uint32_t>(random_bits(seed, 1));
  tree::Node finer{std::move(layers), {}};
  if (bands.waviness > 0) {
    tree::Warp warp;
    warp.amplitude = bands.waviness;
    warp.wavelength = long_as * bands.thickness;
    warp.octaves = 2;
    warp.seed = static_cast<std::uint32_t>(random_bits(seed, 2));
    finer = {warp, {std::move(finer)}};
  }
  return {tree::Blend{}, {std::move(own), std::move(finer)}};
}

}  // namespace hoodoo::generator
