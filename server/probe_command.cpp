#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "engine/base/file.hpp"
#include "engine/scene/scene.hpp"
#include "engine/tree/field.hpp"
#include "server/commands.hpp"
#include "server/signals.hpp"
#include "server/temporary_folder.hpp"

namespace hoodoo {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_bytes = std::size_t{1} << 30;

/// Lines of "x,y,z"; a first line that starts with a letter is a heading.
std::vector<Vec3> read_points(const std::string& file) {
  const auto text = read_file(file, most_bytes);
  std::vector<Vec3> points;
  std::vector<Problem> problems;
  std::size_t line = 0;
  for (std::size_t from = 0; from < text.size() && problems.size() < 20;) {
    const auto to = std::min(text.find('\n', from), text.size());
    const char* at = text.data() + from;
    const char* const end = text.data() + to;
    from = to + 1;
    ++line;
    if (at == end || *at == '\r' || (line == 1 && std::isalpha(static_cast<unsigned char>(*at)))) {
      continue;
    }
    Vec3 p;
    bool good = true;
    for (int axis = 0; axis < 3 && good; ++axis) {
      while (at != end && *at == ' ') ++at;
      const auto read = std::from_chars(at, end, p[axis]);
      good = read.ec == std::errc() && std::isfinite(p[axis]);
      at = read.ptr;
      if (good && axis < 2) good = at != end && *at++ == ',';
    }
    if (good) {
      points.push_back(p);
    } else {
      problems.push_back({fmt::format("{}:{}", file, line), "must be x,y,z in metres"});
    }
  }
  if (!problems.empty()) throw Error(Fault::bad_input, std::move(problems));
  return points;
}

/// Evaluates one point in the level-0 block that owns it.
class Prober {
 public:
  explicit Prober(const scene::Scene& scene) : scene_(scene) {}

  void print(const Vec3& p, bool explain) {
    const double size = 16 * scene_.spacing;
    const Vec3 origin{std::floor(p.x / size) * size, std::floor(p.y / size) * size,
                      std::floor(p.z / size) * size};
    if (!field_ || !(origin == origin_)) compile(origin, size);
    const Vec3 local = p - origin;
    const float x[] = {static_cast<float>(local.x)}, y[] = {static_cast<float>(local.y)},
                z[] = {static_cast<float>(local.z)};
    float value[1], gx[1], gy[1], gz[1], resistance[1];
    int material[1];
    const tree::Points at{x, y, z};
    field_->gradients(at, value, {gx, gy, gz});
    field_->resistances(at, resistance);
    field_->materials(at, material);
    const auto& rock = scene_.ground.materials[static_cast<std::size_t>(material[0])];
    fmt::print("{},{},{},{},{},{},{},{},{}\n", p.x, p.y, p.z, value[0], gx[0], gy[0], gz[0],
               resistance[0], rock.name);
    if (!explain) return;
    for (const auto& line : field_->explain()) fmt::print("# {}\n", line);
  }

 private:
  void compile(const Vec3& origin, double size) {
    const Box box{origin, origin + Vec3{size, size, size}};
    windows_.clear();
    for (const auto& pyramid : scene_.pyramids) {
      windows_.push_back(pyramid->window(pyramid->level_for(scene_.spacing), box));
    }
    field_ = tree::compile(scene_.ground, windows_, origin, box);
    origin_ = origin;
  }

  const scene::Scene& scene_;
  std::vector<dem::Window> windows_;
  std::unique_ptr<const tree::Field> field_;
  Vec3 origin_;
};

}  // namespace

void add_probe(CLI::App& app, int* exit) {
  struct Options {
    std::string scene, points, cache;
    bool explain = false;
  };
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("probe", "Evaluate a scene at points, as CSV");
  command->add_option("scene", options->scene, "The scene file")->required();
  command->add_option("--points", options->points, "CSV of x,y,z [m] in the scene frame")
      ->required();
  command->add_flag("--explain", options->explain, "Say what reaches each point");
  command->add_option("--cache", options->cache, "Keep the elevations in this folder");
  command->callback([=] {
    const Signals signals;
    const auto points = read_points(options->points);
    const TemporaryFolder temporary;
    const fs::path file = options->scene;
    scene::OpenSettings open;
    open.cache = options->cache.empty() ? temporary.path : fs::path(options->cache);
    open.ingest.stop = signals.token();
    open.ingest.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    const auto scene = scene::open(
        scene::read(file), {file.parent_path().empty() ? "." : file.parent_path(), {}}, open);
    Prober prober(scene);
    fmt::print("x,y,z,field,gx,gy,gz,resistance,material\n");
    for (const auto& p : points) prober.print(p, options->explain);
    *exit = 0;
  });
}

}  // namespace hoodoo
