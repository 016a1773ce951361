#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/hydrology/hydrology.hpp"
#include "engine/hydrology/large.hpp"
#include "engine/hydrology/percentiles.hpp"
#include "engine/hydrology/raster_writer.hpp"
#include "server/commands.hpp"

namespace hoodoo {
namespace {

namespace fs = std::filesystem;

struct AnalyzeOptions {
  std::string dem, fill, area, slope, power, access, sea_distance, sinks, routing = "freeman";
  double exponent = 1.1, access_radius = 50, sea_level = 0;
  std::vector<double> percentiles;
  std::size_t memory_mib = 1024;

  bool nothing() const {
    return sinks.empty() && !drains() && fill.empty() && slope.empty() && access.empty() &&
           sea_distance.empty();
  }
  const std::string& first_file() const {
    for (const auto* file : {&fill, &area, &slope, &power, &access, &sea_distance}) {
      if (!file->empty()) return *file;
    }
    return sinks;
  }
  bool drains() const { return !area.empty() || !power.empty(); }
};

/// Column, row, elevation [m], depth [m], area [m^2].
std::string csv_of(const std::vector<hydrology::Sink>& sinks) {
  std::string text = "i,j,elevation,depth,area\n";
  for (const auto& s : sinks) {
    text += fmt::format("{},{},{},{},{}\n", s.i, s.j, s.elevation, s.depth, s.area);
  }
  return text;
}

/// Writes what is asked for and remembers it for the report.
class Analysis {
 public:
  explicit Analysis(const AnalyzeOptions& options)
      : options_(options),
        dem_(options.dem, {options.memory_mib << 20, fs::path(options.first_file()).parent_path()}),
        report_({{"width", dem_.width()}, {"height", dem_.height()}}) {}

  nlohmann::json run() {
    using hydrology::LargeDem, hydrology::TakeRows;
    write(options_.access,
          [&](const TakeRows& take) { dem_.accessibility(options_.access_radius, take); });
    write(options_.sea_distance,
          [&](const TakeRows& take) { dem_.sea_distance(options_.sea_level, take); });
    write(options_.slope, [&](const TakeRows& take) { dem_.slope(take); });
    write(options_.fill, [&](const TakeRows& take) { dem_.filled(take); });
    if (options_.drains()) {
      const auto routing =
          options_.routing == "d8" ? hydrology::Routing::d8 : hydrology::Routing::freeman;
      report_["outflow_m2"] = dem_.accumulate({routing, options_.exponent});
      write(options_.area, [&](const TakeRows& take) { dem_.area(take); });
      write(options_.power, [&](const TakeRows& take) { dem_.stream_power(take); });
    }
    if (!options_.sinks.empty()) write_sinks();
    return std::move(report_);
  }

 private:
  template <class Make>
  void write(const std::string& file, Make make) {
    if (file.empty()) return;
    hydrology::RasterWriter writer(file, options_.dem, dem_.width(), dem_.height());
    make([&](std::span<const float> rows) { writer.append(rows); });
    writer.commit();
    wrote(file);
    if (options_.percentiles.empty()) return;
    const auto found = hydrology::percentiles(file, options_.percentiles);
    auto& list = report_["percentiles"][file] = nlohmann::json::array();
    for (std::size_t n = 0; n < found.size(); ++n) {
      list.push_back({{"percent", options_.percentiles[n]}, {"value", found[n]}});
    }
  }
  void wrote(const std::string& file) { report_["written"].push_back(file); }

  void write_sinks() {
    const auto sinks = dem_.sinks();
    write_file(options_.sinks, csv_of(sinks));
    wrote(options_.sinks);
    report_["sinks"] = sinks.size();
  }

  const AnalyzeOptions& options_;
  hydrology::LargeDem dem_;
  nlohmann::json report_;
};

void print(const nlohmann::json& report) {
  for (const auto& file : report["written"]) {
    const auto name = file.get<std::string>();
    fmt::print("{}\n", name);
    if (!report.contains("percentiles") || !report["percentiles"].contains(name)) continue;
    for (const auto& entry : report["percentiles"][name]) {
      const auto& value = entry["value"];
      fmt::print("  {} %: {}\n", entry["percent"].get<double>(),
                 value.is_null() ? "no value" : fmt::format("{}", value.get<float>()));
    }
  }
}

int run_analyze(const AnalyzeOptions& options, bool as_json) {
  if (options.nothing()) {
    throw Error(Fault::bad_input, "analyze",
                "needs one of --fill, --area, --slope, --power, --access, --sea-distance, --sinks");
  }
  const auto report = Analysis(options).run();
  if (as_json) {
    fmt::print("{}\n", report.dump());
    return 0;
  }
  fmt::print("{}: {} x {} cells\n", options.dem, report["width"].get<int>(),
             report["height"].get<int>());
  print(report);
  return 0;
}

}  // namespace

void add_analyze(CLI::App& app, int* exit) {
  auto options = std::make_shared<AnalyzeOptions>();
  auto* command = app.add_subcommand("analyze", "Where the water of a DEM goes, as rasters");
  command->add_option("dem", options->dem, "The GeoTIFF")->required();
  command->add_option("--fill", options->fill, "Elevations without pits [m]");
  command->add_option("--area", options->area, "Area that drains through each cell [m2]");
  command->add_option("--slope", options->slope, "Rise over run");
  command->add_option("--power", options->power, "Root of the area times the slope [m]");
  command->add_option("--access", options->access,
                      "Radius of the largest ball that touches the ground there from above and "
                      "holds no other, over --access-radius [0, 1]");
  command->add_option("--access-radius", options->access_radius, "Where the ground is open [m]")
      ->check(CLI::Range(0.001, 1e6))
      ->capture_default_str();
  command->add_option("--sea-distance", options->sea_distance,
                      "Distance to the nearest cell at or below --sea-level [m]");
  command->add_option("--sea-level", options->sea_level, "Elevation of the sea [m]")
      ->check(CLI::Range(-1e5, 1e5))
      ->capture_default_str();
  command
      ->add_option("--percentiles", options->percentiles,
                   "Print these of every raster, exact: 50,90,99")
      ->delimiter(',')
      ->check(CLI::Range(0.0, 100.0));
  command->add_option("--sinks", options->sinks,
                      "CSV of pits: column, row, elevation, depth and area of their depression");
  command
      ->add_option("--routing", options->routing,
                   "freeman: to all lower neighbours; d8: to the steepest")
      ->check(CLI::IsMember({"freeman", "d8"}))
      ->capture_default_str();
  command->add_option("--exponent", options->exponent, "Of slopes, by which lower neighbours share")
      ->check(CLI::Range(0.01, 10.0))
      ->capture_default_str();
  command->add_option("--memory", options->memory_mib, "Memory budget [MiB]")
      ->check(CLI::Range(std::size_t{64}, std::size_t{1} << 24))
      ->capture_default_str();
  command->callback([=, &app] { *exit = run_analyze(*options, json_wanted(app)); });
}

}  // namespace hoodoo
