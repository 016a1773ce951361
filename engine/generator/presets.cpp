#include "engine/generator/hoodoos.hpp"

namespace hoodoo::generator {
namespace {

// After figures 5, 18 and 21 of Paris et al. 2019. s is the radius of the foot [m]. The waist of a
// column is as thin as the rock is weak: mix(waist, 1, rho).
// clang-format off

/// A talus foot, a column of uneven layers, and a wide cap with a block on top.
constexpr std::string_view hoodoo = R"json({
  "axiom": "A",
  "parameters": {"height": 14, "radius": 2.4, "cap": 1.25, "waist": 0.45, "taper": 0.97},
  "rules": [
    {"symbol": "A", "to": ["foot", {"symbol": "B", "move": [0, 0, "0.8*s"], "scale": 0.74}]},
    {"symbol": "B", "probability": "clamp((0.8*height - h) / s, 0, 1)",
     "to": ["layer", {"symbol": "B", "move": ["0.24*s*(u-0.5)", "0.24*s*(u-0.5)", "s*(0.55+0.35*u)"],
                      "scale": "taper", "rotate": {"axis": [0, 0, 1], "angle": "360*u"}}]},
    {"symbol": "B", "to": ["neck", {"symbol": "C", "move": [0, 0, "0.35*s"], "scale": "cap"}]},
    {"symbol": "C", "probability": 0.65,
     "to": ["cap", {"terminal": "block", "move": ["0.3*s*(u-0.5)", "0.3*s*(u-0.5)", "0.85*s"],
                    "scale": "0.55+0.2*u"}]},
    {"symbol": "C", "to": ["cap"]}],
  "terminals": {
    "foot": {"type": "cone", "base": [0, 0, "-0.6*s"], "tip": [0, 0, "2.4*s + 0.12*height"],
             "radius": "1.25*s", "falloff": "0.8*s",
             "turbulence": {"amplitude": "0.16*s", "wavelength": "1.1*s", "octaves": 4}},
    "layer": {"type": "sphere", "center": [0, 0, 0], "radius": "s*mix(waist, 1, rho)*(0.9+0.2*u)",
              "falloff": "0.8*s",
              "turbulence": {"amplitude": "0.13*s", "wavelength": "0.9*s", "octaves": 4}},
    "neck": {"type": "sphere", "center": [0, 0, 0], "radius": "0.8*s*mix(waist, 1, rho)",
             "falloff": "0.8*s"},
    "cap": {"type": "truncated_cone", "base": [0, 0, "0.05*s"], "top": [0, 0, "0.85*s"],
            "base_radius": "s*(0.75+0.3*rho)", "top_radius": "s*(0.5+0.3*rho)", "falloff": "0.6*s",
            "turbulence": {"amplitude": "0.2*s", "wavelength": "1.1*s", "octaves": 4}},
    "block": {"type": "sphere", "center": [0, 0, 0], "radius": "s*(0.7+0.3*rho)",
              "falloff": "0.7*s",
              "turbulence": {"amplitude": "0.18*s", "wavelength": "1.1*s", "octaves": 4}}}
})json";

/// A squat foot, a neck that the weather has thinned, and a bulb of two or three lumps.
constexpr std::string_view goblin = R"json({
  "axiom": "A",
  "parameters": {"height": 3.6, "radius": 1.1, "cap": 1.3, "waist": 0.6},
  "rules": [
    {"symbol": "A", "to": ["foot", {"symbol": "B", "move": [0, 0, "0.42*height"], "scale": 0.8,
                                    "rotate": {"axis": [0, 0, 1], "angle": "360*u"}}]},
    {"symbol": "B", "to": ["neck", {"symbol": "C", "move": [0, 0, "0.28*height"], "scale": "cap"}]},
    {"symbol": "C", "probability": "0.35*(1-rho)",
     "to": ["head", {"symbol": "C", "move": ["0.25*s", 0, "0.75*s"], "scale": 0.72,
                     "rotate": {"axis": [0, 0, 1], "angle": "360*u"}}]},
    {"symbol": "C", "probability": 0.45,
     "to": ["head", {"terminal": "lump", "move": ["0.55*s", 0, "0.1*s"], "scale": "0.5+0.3*u"},
            {"terminal": "lump", "move": ["-0.45*s", "0.3*s", "-0.15*s"], "scale": "0.45+0.25*u"}]},
    {"symbol": "C", "to": ["head"]}],
  "terminals": {
    "foot": {"type": "truncated_cone", "base": [0, 0, "-0.5*s"], "top": [0, 0, "0.5*height"],
             "base_radius": "1.2*s", "top_radius": "0.62*s*mix(waist, 1, rho)", "falloff": "0.7*s",
             "turbulence": {"amplitude": "0.14*s", "wavelength": "1.2*s"}},
    "neck": {"type": "sphere", "center": [0, 0, 0], "radius": "0.95*s*mix(waist, 1, rho)",
             "falloff": "0.8*s", "turbulence": {"amplitude": "0.1*s", "wavelength": "1.1*s"}},
    "head": {"type": "sphere", "center": [0, 0, 0], "radius": "s*(0.8+0.35*rho)",
             "falloff": "0.8*s", "turbulence": {"amplitude": "0.18*s", "wavelength": "1.3*s"}},
    "lump": {"type": "sphere", "center": [0, 0, 0], "radius": "s", "falloff": "0.7*s",
             "turbulence": {"amplitude": "0.12*s", "wavelength": "1.1*s"}}}
})json";

/// Blocks that grow smaller upward, now and then with a smaller spire beside the first.
constexpr std::string_view rock_spire = R"json({
  "axiom": "A",
  "parameters": {"height": 22, "radius": 3, "waist": 0.7},
  "rules": [
    {"symbol": "A", "to": ["foot", {"symbol": "S", "move": [0, 0, "0.3*s"], "scale": 0.85},
                           {"symbol": "D", "rotate": {"axis": [0, 0, 1], "angle": "360*u"}}]},
    {"symbol": "D", "probability": 0.5,
     "to": [{"symbol": "T", "move": ["0.7*s", 0, "0.2*s"], "scale": "0.45+0.2*u"}]},
    {"symbol": "D", "to": []},
    {"symbol": "S", "probability": "clamp((0.86*height - h) / s, 0, 1)",
     "to": ["block", {"symbol": "S", "move": ["0.2*s*(u-0.5)", "0.2*s*(u-0.5)", "s*(0.8+0.4*u)"],
                      "scale": "pow(0.3, 1.25*s / height)",
                      "rotate": {"axis": [0, 0, 1], "angle": "360*u"}}]},
    {"symbol": "S", "to": ["tip"]},
    {"symbol": "T", "probability": "clamp((0.5*height - h) / s, 0, 1) * clamp(8*s/radius - 1, 0, 1)",
     "to": ["block", {"symbol": "T", "move": ["0.2*s*(u-0.5)", "0.2*s*(u-0.5)", "s*(0.8+0.4*u)"],
                      "scale": 0.87}]},
    {"symbol": "T", "to": ["tip"]}],
  "terminals": {
    "foot": {"type": "cone", "base": [0, 0, "-0.6*s"], "tip": [0, 0, "1.8*s"], "radius": "1.4*s",
             "falloff": "0.8*s",
             "turbulence": {"amplitude": "0.18*s", "wavelength": "1.2*s", "octaves": 4}},
    "block": {"type": "truncated_cone", "base": [0, 0, "-0.35*s"], "top": [0, 0, "1.15*s"],
              "base_radius": "0.95*s*mix(waist, 1, rho)", "top_radius": "0.72*s*mix(waist, 1, rho)",
              "falloff": "0.5*s",
              "turbulence": {"amplitude": "0.18*s", "wavelength": "0.9*s", "octaves": 4}},
    "tip": {"type": "cone", "base": [0, 0, "-0.4*s"], "tip": [0, 0, "1.8*s"], "radius": "0.95*s",
            "falloff": "0.5*s",
            "turbulence": {"amplitude": "0.06*s", "wavelength": "0.8*s", "octaves": 4}}}
})json";

/// A pedestal, a thin neck, and a boulder that lies a little off it.
constexpr std::string_view balanced_rock = R"json({
  "axiom": "A",
  "parameters": {"height": 9, "radius": 2.2, "cap": 1.2, "waist": 0.5},
  "rules": [
    {"symbol": "A", "to": ["pedestal", {"symbol": "N", "move": [0, 0, "0.48*height"], "scale": 0.6}]},
    {"symbol": "N", "to": ["neck", {"symbol": "R", "move": ["0.5*s*(u-0.5)", "0.5*s*(u-0.5)",
                                                           "0.26*height"],
                                    "scale": "1.6*cap",
                                    "rotate": {"axis": [0, 0, 1], "angle": "360*u"}}]},
    {"symbol": "R", "to": ["boulder",
                           {"terminal": "shoulder", "move": ["0.45*s", 0, "0.12*s"],
                            "scale": "0.6+0.2*u"},
                           {"terminal": "shoulder", "move": ["-0.4*s", "0.2*s", "-0.08*s"],
                            "scale": "0.6+0.2*u"}]}],
  "terminals": {
    "pedestal": {"type": "truncated_cone", "base": [0, 0, "-0.6*s"], "top": [0, 0, "0.5*height"],
                 "base_radius": "1.3*s", "top_radius": "0.62*s*mix(waist, 1, rho)",
                 "falloff": "0.8*s",
                 "turbulence": {"amplitude": "0.16*s", "wavelength": "1.1*s", "octaves": 4}},
    "neck": {"type": "sphere", "center": [0, 0, 0], "radius": "0.95*s*mix(waist, 1, rho)",
             "falloff": "0.7*s",
             "turbulence": {"amplitude": "0.1*s", "wavelength": "s", "octaves": 4}},
    "boulder": {"type": "sphere", "center": [0, 0, 0], "radius": "0.8*s*(0.8+0.3*rho)",
                "falloff": "0.7*s",
                "turbulence": {"amplitude": "0.15*s", "wavelength": "1.2*s", "octaves": 4}},
    "shoulder": {"type": "sphere", "center": [0, 0, 0], "radius": "s*(0.8+0.2*rho)",
                 "falloff": "0.7*s",
                 "turbulence": {"amplitude": "0.14*s", "wavelength": "1.2*s", "octaves": 4}}}
})json";

// clang-format on
}  // namespace

std::string_view preset_grammar(Preset preset) {
  switch (preset) {
    case Preset::hoodoo:
      return hoodoo;
    case Preset::goblin:
      return goblin;
    case Preset::rock_spire:
      return rock_spire;
    default:
      return balanced_rock;
  }
}

}  // namespace hoodoo::generator
