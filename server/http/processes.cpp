#include "server/http/processes.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "server/job/job.hpp"

namespace hoodoo::http {
namespace {

using nlohmann::json;

struct Process {
  std::string_view id;
  const char* title;
  const char* description;
  Control control;
};

constexpr std::array<Process, 5> all{
    {{job::bake_process,
      "Bake terrain",
      "Turns elevation models and a scene into glTF tiles with a 3D Tiles 1.1 index.",
      {true, false}},
     {validate_process,
      "Validate a scene",
      "Lists every problem of a scene, each with its JSON Pointer, without baking it.",
      {false, true}},
     {job::analyze_process,
      "Analyze a DEM",
      "Where the water of an elevation model goes: rasters in its place, and its pits.",
      {true, false}},
     {job::diff_process,
      "Compare two tilesets",
      "Where and how far the surfaces of two finished bakes differ.",
      {true, false}},
     {echo_process, "Echo", "Gives back what it is given, for testing clients.", {true, true}}}};

const Process* find(std::string_view id) {
  const auto* found = std::ranges::find(all, id, &Process::id);
  return found == all.end() ? nullptr : found;
}

json summary(const Process& process, const std::string& base) {
  const std::string self = base + "/processes/" + std::string(process.id);
  json control = json::array();
  if (process.control.sync) control.push_back("sync-execute");
  if (process.control.async) control.insert(control.end(), {"async-execute", "dismiss"});
  const bool by_value = process.control.sync;
  return {{"id", process.id},
          {"title", process.title},
          {"description", process.description},
          {"version", HOODOO_VERSION},
          {"jobControlOptions", control},
          {"outputTransmission", json::array({by_value ? "value" : "reference"})},
          {"links",
           {{{"href", self},
             {"rel", "self"},
             {"type", "application/json"},
             {"title", "The process in full"}},
            {{"href", self + "/execution"},
             {"rel", "http://www.opengis.net/def/rel/ogc/1.0/execute"},
             {"type", "application/json"},
             {"title", "POST an execution here"}}}}};
}

json input(const char* title, const char* description, json schema, int least = 1) {
  return {{"title", title},
          {"description", description},
          {"minOccurs", least},
          {"maxOccurs", 1},
          {"schema", std::move(schema)}};
}

json output(const char* title, const char* description, const char* type = "application/json") {
  return {{"title", title},
          {"description", description},
          {"schema", {{"type", "string"}, {"contentMediaType", type}}}};
}

void describe_bake(json& process, const json& scene_schema) {
  process["inputs"]["scene"] =
      input("Scene",
            "What to bake. Files are named below the folders this server was given; an asset by "
            "its name, sha256-HEX. May be left out where base and edit make it.",
            scene_schema, 0);
  process["inputs"]["base"] =
      input("Base",
            "An earlier bake, by the id of its job or a reference to it: what would be the same is "
            "taken from it.",
            {{"type", "string"}}, 0);
  process["inputs"]["edit"] = input(
      "Edit",
      "In place of a scene: a JSON Patch (RFC 6902, without copy and move) of the base's scene, of "
      "1000 changes at most.",
      {{"type", "array"}, {"items", {{"type", "object"}}}}, 0);
  process["outputs"] = {
      {"tileset", output("Tileset", "tileset.json of 3D Tiles 1.1")},
      {"manifest", output("Manifest", "bake.json: every tile with its hashes and numbers")},
      {"report", output("Report", "Counts and warnings of the bake")}};
}

void describe_validate(json& process, const json& scene_schema) {
  process["inputs"]["scene"] = input("Scene", "What to look at.", scene_schema);
  const json problem{
      {"type", "object"},
      {"properties", {{"pointer", {{"type", "string"}}}, {"detail", {{"type", "string"}}}}}};
  process["outputs"] = {
      {"valid", {{"title", "Whether it can be baked"}, {"schema", {{"type", "boolean"}}}}},
      {"problems",
       {{"title", "What is wrong"}, {"schema", {{"type", "array"}, {"items", problem}}}}}};
}

void describe_analyze(json& process) {
  process["inputs"] = {
      {"dem", input("Elevation model",
                    "A GeoTIFF: the name of a file below the folders this server was given, or of "
                    "an asset, sha256-HEX.",
                    {{"type", "string"}})},
      {"routing",
       input("Routing", "To all lower neighbours, or to the steepest.",
             {{"type", "string"}, {"enum", {"freeman", "d8"}}, {"default", "freeman"}}, 0)}};
  const auto raster = [](const char* title, const char* description) {
    return output(title, description, "image/tiff; application=geotiff");
  };
  process["outputs"] = {
      {"fill", raster("Filled", "Elevations without pits [m]")},
      {"area", raster("Drainage area", "Area that drains through each cell [m2]")},
      {"slope", raster("Slope", "Rise over run")},
      {"power", raster("Stream power", "Root of the area times the slope [m]")},
      {"sinks", output("Pits", "Column, row, elevation, depth and area", "text/csv")},
      {"report", output("Report", "Size, outflow and number of pits")}};
}

void describe_diff(json& process) {
  const char* what =
      "A finished bake: the id of a job, the name of a tileset that is served, or a reference to "
      "one of them.";
  process["inputs"] = {
      {"first", input("First", what, {{"type", "string"}})},
      {"second", input("Second", what, {{"type", "string"}})},
      {"tolerance",
       input("Tolerance", "Distance [m] up to which leaves are the same; 2^L times that at level L",
             {{"type", "number"}, {"minimum", 0}, {"maximum", 1e6}, {"default", 0}}, 0)}};
  process["outputs"] = {
      {"report", output("Report", "Tile by tile, the worst first")},
      {"page", output("Page", "The same with pictures of the worst tiles", "text/html")}};
}

void describe_echo(json& process) {
  process["inputs"] = {
      {"echo", input("Anything", "What to give back.", json::object())},
      {"pause",
       input("Pause", "How long to wait before [s].",
             {{"type", "number"}, {"minimum", 0}, {"maximum", most_pause}, {"default", 0}}, 0)}};
  process["outputs"] = {{"echo", {{"title", "What was given"}, {"schema", json::object()}}}};
}

}  // namespace

std::optional<Control> control_of(std::string_view process) {
  const auto* found = find(process);
  if (found == nullptr) return std::nullopt;
  return found->control;
}

std::vector<std::string> output_names(std::string_view process) {
  std::vector<std::string> names;
  const auto described = process_description(process, "", json::object());
  for (const auto& output : described["outputs"].items()) names.push_back(output.key());
  return names;
}

json process_list(const std::string& base) {
  json list = json::array();
  for (const auto& process : all) list.push_back(summary(process, base));
  const json self{{"href", base + "/processes"},
                  {"rel", "self"},
                  {"type", "application/json"},
                  {"title", "This list"}};
  return {{"processes", list}, {"links", json::array({self})}};
}

json process_description(std::string_view id, const std::string& base, const json& scene_schema) {
  auto process = summary(*find(id), base);
  if (id == job::bake_process) describe_bake(process, scene_schema);
  if (id == validate_process) describe_validate(process, scene_schema);
  if (id == job::analyze_process) describe_analyze(process);
  if (id == job::diff_process) describe_diff(process);
  if (id == echo_process) describe_echo(process);
  return process;
}

}  // namespace hoodoo::http
