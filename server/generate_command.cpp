#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <thread>
#include <variant>

#include "engine/base/file.hpp"
#include "engine/base/file_writer.hpp"
#include "engine/scene/scene.hpp"
#include "engine/tree/parse.hpp"
#include "server/commands.hpp"
#include "server/signals.hpp"
#include "server/temporary_folder.hpp"

namespace hoodoo {
namespace {

namespace fs = std::filesystem;

struct GenerateOptions {
  std::string scene, out, cache;
  int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::size_t memory_mib = 1024;
  bool explain = false;
};

/// A generator's name in tables: the id of its operation, or where that stands.
std::string name_of(const generator::Record& record) {
  return record.id.empty() ? record.where : record.id;
}

std::span<const tree::Step> steps_of(const generator::Record& record, const tree::Ground& ground) {
  return std::span(ground.steps).subspan(record.first_step, record.steps);
}

const tree::Balls* balls_of(const tree::Node& tree) {
  return std::visit(
      [](const auto& node) -> const tree::Balls* {
        if constexpr (requires { node.balls.in_file(); }) return &node.balls;
        return nullptr;
      },
      tree.value);
}

/// primitives.csv: every ball of lists of balls; trees.json: everything else.
void write_primitives(const fs::path& folder, const scene::Scene& scene) {
  FileWriter csv(folder / "primitives.csv");
  csv.write("generator,step,operation,x,y,z,radius,energy\n");
  constexpr std::string_view operations[] = {"blend",      "carve",     "union",
                                             "difference", "intersect", "replace"};
  auto trees = nlohmann::json::array();
  for (const auto& record : scene.grown) {
    std::size_t number = 0;
    for (const auto& step : steps_of(record, scene.ground)) {
      const auto operation = operations[static_cast<std::size_t>(step.operation)];
      if (const auto* balls = balls_of(step.tree)) {
        for (const auto& b : balls->list()) {
          csv.write(fmt::format("{},{},{},{},{},{},{},{}\n", name_of(record), number, operation,
                                b.center.x, b.center.y, b.center.z, b.radius, b.energy));
        }
      } else {
        trees.push_back({{"generator", name_of(record)},
                         {"step", number},
                         {"operation", operation},
                         {"tree", tree::to_json(step.tree)}});
      }
      ++number;
    }
  }
  csv.commit();
  write_file(folder / "trees.json", trees.dump(1) + "\n");
}

/// marks.csv: where each generator looked or began.
void write_marks(const fs::path& folder, const scene::Scene& scene) {
  FileWriter csv(folder / "marks.csv");
  csv.write("generator,kind,x,y,z,value\n");
  for (const auto& record : scene.grown) {
    for (const auto& [kind, marks] : record.marks) {
      for (const auto& mark : marks) {
        csv.write(fmt::format("{},{},{},{},{},{}\n", name_of(record), kind, mark.at.x, mark.at.y,
                              mark.at.z, mark.value));
      }
    }
  }
  csv.commit();
}

/// edges.csv: which marks of a kind belong together, each by its place among those of the generator
/// and kind, from 0.
void write_edges(const fs::path& folder, const scene::Scene& scene) {
  FileWriter csv(folder / "edges.csv");
  csv.write("generator,kind,from,to\n");
  for (const auto& record : scene.grown) {
    for (const auto& [kind, edges] : record.edges) {
      for (const auto& edge : edges) {
        csv.write(fmt::format("{},{},{},{}\n", name_of(record), kind, edge.from, edge.to));
      }
    }
  }
  csv.commit();
}

/// What each generator did, and what its trees come to.
nlohmann::json report_of(const scene::Scene& scene) {
  auto generators = nlohmann::json::array();
  std::size_t nodes = 0, bytes = 0;
  for (const auto& record : scene.grown) {
    std::size_t own_nodes = 0, own_bytes = 0;
    for (const auto& step : steps_of(record, scene.ground)) {
      own_nodes += tree::count(step.tree);
      own_bytes += tree::memory(step.tree);
    }
    auto counts = nlohmann::json::object();
    for (const auto& [what, count] : record.counts) counts[what] = count;
    generators.push_back({{"type", record.type},
                          {"id", record.id},
                          {"where", record.where},
                          {"counts", std::move(counts)},
                          {"steps", record.steps},
                          {"nodes", own_nodes},
                          {"bytes", own_bytes}});
    nodes += own_nodes;
    bytes += own_bytes;
  }
  return {{"generators", std::move(generators)}, {"nodes", nodes}, {"bytes", bytes}};
}

void print(const nlohmann::json& report, const scene::Scene& scene, bool explain) {
  for (std::size_t i = 0; i < scene.grown.size(); ++i) {
    const auto& record = scene.grown[i];
    const auto& one = report["generators"][i];
    fmt::print("{}: {}, {} nodes in {} trees, {} bytes\n", name_of(record), record.type,
               one["nodes"].get<std::size_t>(), record.steps, one["bytes"].get<std::size_t>());
    if (!explain) continue;
    for (const auto& [what, count] : record.counts) fmt::print("  {:>10} {}\n", count, what);
  }
  for (const auto& warning : scene.warnings) fmt::print(stderr, "hoodoo: warning: {}\n", warning);
}

int run_generate(const GenerateOptions& options, bool as_json) {
  const Signals signals;
  const TemporaryFolder temporary;
  const fs::path file = options.scene, folder = options.out;
  scene::OpenSettings open;
  open.cache = options.cache.empty() ? temporary.path : fs::path(options.cache);
  open.ingest.stop = signals.token();
  open.ingest.threads = options.threads;
  open.ingest.memory = options.memory_mib << 19;
  open.keep_marks = true;
  const auto scene = scene::open(scene::read(file),
                                 {file.parent_path().empty() ? "." : file.parent_path(), {}}, open);
  const auto report = report_of(scene);
  if (!options.out.empty()) {
    write_primitives(folder, scene);
    write_marks(folder, scene);
    write_edges(folder, scene);
    write_file(folder / "report.json", report.dump(1) + "\n");
  }
  if (as_json) {
    fmt::print("{}\n", report.dump());
  } else {
    print(report, scene, options.explain);
  }
  return 0;
}

}  // namespace

void add_generate(CLI::App& app, int* exit) {
  auto options = std::make_shared<GenerateOptions>();
  auto* command =
      app.add_subcommand("generate", "What the generators of a scene make, without baking it");
  command->add_option("scene", options->scene, "The scene file")->required();
  command->add_option(
      "-o,--out", options->out,
      "Folder for primitives.csv, trees.json, marks.csv, edges.csv and report.json");
  command->add_flag("--explain", options->explain,
                    "Say how much was sampled, rejected, and why, and placed");
  command->add_option("--threads", options->threads, "Threads")->check(CLI::Range(1, 1024));
  command->add_option("--memory", options->memory_mib, "Memory budget [MiB]")
      ->check(CLI::Range(std::size_t{64}, std::size_t{1} << 24))
      ->capture_default_str();
  command->add_option("--cache", options->cache, "Keep the elevations in this folder");
  command->callback([=, &app] { *exit = run_generate(*options, json_wanted(app)); });
}

}  // namespace hoodoo
