#include "tests/bench/surface.hpp"

#include <string>

#include "tests/bench/measure.hpp"
#include "tests/bench/narrow_band.hpp"
#include "tests/bench/paper.hpp"

namespace hoodoo::bench {
namespace {

void compare(const Scene& scene, const std::string& name, const char* goal) {
  const NarrowBand band(scene);
  Paper paper(scene);
  Paper::Result theirs;
  std::size_t ours = 0;
  const auto [seconds, paper_seconds] =
      median_seconds([&] { ours = band.triangles(); }, [&] { theirs = paper.run(); });
  const double columns = static_cast<double>(scene.wide) * scene.wide;
  fmt::print("{}: {} x {} columns, {} balls over {:.3f} of them\n", name, scene.wide, scene.wide,
             scene.balls.size(), static_cast<double>(theirs.covered) / columns);
  fmt::print("  {:56} {:9.3f} s, {} triangles, {:.1f} M calls\n", "Paris et al. 2019, section 7",
             paper_seconds, theirs.triangles, static_cast<double>(theirs.calls) / 1e6);
  fmt::print("  {:56} {:9.3f} s, {} triangles\n", "tile by tile: cut, sampled, dual contoured",
             seconds, ours);
  ratio((name + ": Paris et al. 2019 / ours").c_str(), paper_seconds / seconds, goal);
  ratio((name + ": with elevations known to theirs beforehand").c_str(),
        (paper_seconds - theirs.looking_up) / seconds, "to compare");
}

}  // namespace

void compare_surface() {
  compare(sea(), "sea", ">= 4");
  compare(canyon(), "canyon", ">= 10");
}

}  // namespace hoodoo::bench
