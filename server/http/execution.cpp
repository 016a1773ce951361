#include "server/http/execution.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "engine/scene/files.hpp"
#include "server/asset/assets.hpp"
#include "server/http/api.hpp"
#include "server/http/callback_target.hpp"
#include "server/http/problem.hpp"
#include "server/http/processes.hpp"

namespace hoodoo::http {
namespace {

using nlohmann::json;

[[noreturn]] void refuse(const std::string& pointer, std::string what) {
  throw Error(Fault::bad_input, pointer, std::move(what));
}

JsonLimits limits() {
  JsonLimits limits;
  limits.bytes = most_body;
  limits.values = 1'000'000;
  return limits;
}

/// What parsed JSON takes, not less than it does: values and members by the marks around them.
std::size_t memory_of(std::string_view text) {
  constexpr std::size_t value = 24, array = 48, object = 80, member = 96,
                        half_text = 24;  // [bytes]
  std::size_t sum = text.size();
  bool in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') {
      in_text = !in_text;
      sum += half_text;
    } else if (in_text) {
      if (c == '\\') ++i;
    } else if (c == ',') {
      sum += value;
    } else if (c == ':') {
      sum += member;
    } else if (c == '[') {
      sum += array;
    } else if (c == '{') {
      sum += object;
    }
  }
  return sum;
}

json parse(const std::string& text, const std::string& where) {
  if (memory_of(text) > most_parsed) {
    throw Error(Fault::limit, where,
                fmt::format("holds too many values: parsed it would take more than {} MiB",
                            most_parsed >> 20));
  }
  return parse_json(text, where, limits());
}

/// The path of `name` below a root.
std::filesystem::path file_below(const std::string& name, const std::string& pointer,
                                 const References& references) {
  scene::Findings findings;
  const auto found =
      scene::find_file(name, pointer, {references.roots.front(), references.roots}, findings);
  if (!found) throw Error(Fault::bad_input, findings.all());
  return *found;
}

/// What of this server an input's href names: "file:NAME", or an address of the service itself,
/// of which the path is left.
struct Target {
  bool is_file = false;
  std::string name;
};
Target target_of(const json& value, const std::string& pointer, const References& references) {
  const auto& href = value.at("href");
  if (!href.is_string()) refuse(pointer + "/href", "must be a string");
  const auto text = href.get<std::string>();
  if (text.starts_with("file:")) return {true, text.substr(5)};
  const auto assets = references.base + "/assets/";
  if (text.starts_with(assets)) {
    const auto name = text.substr(assets.size());
    if (!asset::digest_of(name)) refuse(pointer + "/href", "must end in sha256-HEX");
    return {true, name};
  }
  if (text.starts_with(references.base + "/")) return {false, text.substr(references.base.size())};
  refuse(pointer + "/href", "must be file:NAME or an address of this server; others are not asked");
}
bool is_reference(const json& value) { return value.is_object() && value.contains("href"); }

json scene_of(json value, const References& references) {
  const std::string pointer = "/inputs/scene";
  if (!value.is_object()) refuse(pointer, "must be an object");
  if (!is_reference(value)) return value;
  const auto target = target_of(value, pointer, references);
  if (!target.is_file) refuse(pointer + "/href", "is no file");
  const auto file = file_below(target.name, pointer + "/href", references);
  references.before_reading();
  auto scene = parse(read_file(file, most_body), target.name);
  if (!scene.is_object()) refuse(pointer + "/href", "is no object");
  return scene;
}

std::string dem_of(const json& value, const References& references) {
  std::string pointer = "/inputs/dem";
  if (value.is_string()) return file_below(value.get<std::string>(), pointer, references);
  if (!is_reference(value)) refuse(pointer, "must be the name of a file, or a reference");
  const auto target = target_of(value, pointer, references);
  pointer += "/href";
  if (!target.is_file) refuse(pointer, "is no file");
  return file_below(target.name, pointer, references);
}

/// ".../jobs/ID" or ".../tilesets/NAME", whatever follows; or that last part alone.
std::string bake_named(const json& value, const std::string& pointer,
                       const References& references) {
  if (value.is_string()) return value.get<std::string>();
  if (!is_reference(value)) return {};
  const auto target = target_of(value, pointer, references);
  for (const std::string_view start : {"/jobs/", "/tilesets/"}) {
    if (target.is_file || !target.name.starts_with(start)) continue;
    const auto name = target.name.substr(start.size());
    return name.substr(0, name.find('/'));
  }
  return {};
}
std::string tileset_of(const json& value, const std::string& pointer,
                       const References& references) {
  const auto name = bake_named(value, pointer, references);
  const auto folder = references.tileset(name);
  if (!folder) refuse(pointer, "must name a finished bake: a job's id, or a tileset's name");
  return folder->string();
}

bool wants(const std::vector<std::string>& outputs, std::string_view name) {
  return outputs.empty() || std::ranges::find(outputs, name) != outputs.end();
}

/// What is wrong with one output of a body.
void check_output(std::string_view process, const std::vector<std::string>& names,
                  const std::string& name, const json& value, std::vector<Problem>& problems) {
  const auto pointer = "/outputs/" + pointer_token(name);
  if (std::ranges::find(names, name) == names.end()) {
    problems.push_back({pointer, "is no output of this process, which has " + json(names).dump()});
    return;
  }
  if (!value.is_object()) {
    problems.push_back({pointer, "must be an object"});
    return;
  }
  const auto* given = control_of(process)->sync ? "value" : "reference";
  if (value.contains("transmissionMode") && value["transmissionMode"] != given) {
    problems.push_back({pointer + "/transmissionMode",
                        fmt::format("must be \"{}\", as this process gives it", given)});
  }
}

/// Names of the outputs that are wanted; none when the body does not say, for all.
std::vector<std::string> outputs_of(std::string_view process, const json& body) {
  if (!body.contains("outputs")) return {};
  if (!body["outputs"].is_object()) refuse("/outputs", "must be an object");
  const auto names = output_names(process);
  if (body["outputs"].size() > names.size()) {
    refuse("/outputs", fmt::format("has {} members, this process has {} outputs: {}",
                                   body["outputs"].size(), names.size(), json(names).dump()));
  }
  std::vector<std::string> wanted;
  std::vector<Problem> problems;
  for (const auto& item : body["outputs"].items()) {
    check_output(process, names, item.key(), item.value(), problems);
    wanted.push_back(item.key());
  }
  if (!problems.empty()) throw Error(Fault::bad_input, std::move(problems));
  return wanted;
}

/// Of an analysis those that are wanted, and one at least: there is none without.
json files_of(const std::vector<std::string>& outputs) {
  json files = json::array();
  for (const auto* name : {"fill", "area", "slope", "power", "sinks"}) {
    if (wants(outputs, name)) files.push_back(name);
  }
  if (files.empty()) files.push_back("sinks");
  return files;
}

double number_of(const json& inputs, const char* name, double most) {
  if (!inputs.contains(name)) return 0;
  const auto& value = inputs[name];
  if (!value.is_number() || !(value.get<double>() >= 0) || value.get<double>() > most) {
    refuse(std::string("/inputs/") + name, fmt::format("must be a number in [0, {}]", most));
  }
  return value.get<double>();
}

/// Every member is one of these, and the first is there.
void check_names(const json& inputs, const std::vector<std::string>& names, std::size_t required) {
  std::vector<Problem> problems;
  for (const auto& item : inputs.items()) {
    if (std::ranges::find(names, item.key()) == names.end()) {
      problems.push_back({"/inputs/" + pointer_token(item.key()), "is no input of this process"});
    }
  }
  for (std::size_t i = 0; i < required; ++i) {
    if (!inputs.contains(names[i])) problems.push_back({"/inputs/" + names[i], "is missing"});
  }
  if (!problems.empty()) throw Error(Fault::bad_input, std::move(problems));
}

/// One change of a JSON Patch. The library does not notice a path below a text or a number.
void apply(json& scene, const json& change, const std::string& where) {
  constexpr std::size_t deepest = 64;
  const json known{"add", "remove", "replace", "test"};
  const auto op = change.is_object() ? change.value("op", json()) : json();
  if (std::ranges::find(known, op) == known.end()) {
    refuse(where + "/op", "must be one of " + known.dump());
  }
  const auto path = change.value("path", json());
  if (!path.is_string()) refuse(where + "/path", "must be a string");
  const auto& text = path.get_ref<const std::string&>();
  if (std::ranges::count(text, '/') > static_cast<std::ptrdiff_t>(deepest)) {
    refuse(where + "/path", fmt::format("leads deeper than {} levels", deepest));
  }
  try {
    const json::json_pointer place(text);
    if (!place.empty() && !scene.at(place.parent_pointer()).is_structured()) {
      throw Error(Fault::bad_input, where, "");
    }
    scene.patch_inplace(json::array({change}));
  } catch (const std::exception&) {
    refuse(where, op == "test" ? "does not hold for the scene of the base"
                               : "has no value, or its path does not lead into the scene of the "
                                 "base");
  }
}

/// The scene in a file of the base, changed by a JSON Patch (RFC 6902). Without "copy" and "move",
/// by which few bytes could take much time and memory.
json edited(const std::filesystem::path& base, const json& patch, const References& references) {
  constexpr std::size_t most_changes = 1000;
  const std::string pointer = "/inputs/edit";
  if (!patch.is_array()) refuse(pointer, "must be a JSON Patch, an array of changes");
  if (patch.size() > most_changes) {
    refuse(pointer, fmt::format("has {} changes, the limit is {}", patch.size(), most_changes));
  }
  references.before_reading();
  json scene;
  try {
    scene = parse(read_file(base, most_body), "");
  } catch (const Error&) {
    refuse("/inputs/base", "has no scene any more, or too large a one");
  }
  for (std::size_t n = 0; n < patch.size(); ++n) {
    apply(scene, patch[n], fmt::format("{}/{}", pointer, n));
  }
  if (!scene.is_object()) refuse(pointer, "leaves no object");
  if (scene.dump().size() > most_body) {
    refuse(pointer, fmt::format("makes a scene of more than {} bytes", most_body));
  }
  return scene;
}

json bake_inputs_of(json& inputs, const References& references) {
  check_names(inputs, {"scene", "base", "edit"}, 0);
  const bool changed = inputs.contains("edit");
  if (changed == inputs.contains("scene")) {
    refuse("/inputs/scene", changed ? "is one too many beside edit" : "is missing");
  }
  if (changed && !inputs.contains("base")) refuse("/inputs/base", "is missing: edit changes it");
  json read;
  std::optional<std::filesystem::path> base;
  if (inputs.contains("base")) {
    read["base"] = bake_named(inputs["base"], "/inputs/base", references);
    base = references.scene(read["base"].get<std::string>(), changed);
    if (!base) {
      refuse("/inputs/base", std::string("must name a finished bake by its job's id") +
                                 (changed ? ", one of the same key to edit its scene" : ""));
    }
  }
  read["scene"] = changed ? edited(*base, inputs["edit"], references)
                          : scene_of(std::move(inputs["scene"]), references);
  return read;
}

/// Takes what it needs out of the body, which may be large: it was of `size` bytes.
json inputs_of(std::string_view process, json& body, std::size_t size,
               const std::vector<std::string>& outputs, const References& references) {
  auto& inputs = body.at("inputs");
  if (process == job::analyze_process) {
    check_names(inputs, {"dem", "routing"}, 1);
    const auto routing = inputs.value("routing", json("freeman"));
    if (routing != "freeman" && routing != "d8") refuse("/inputs/routing", "must be freeman or d8");
    return {{"dem", dem_of(inputs["dem"], references)},
            {"routing", routing},
            {"outputs", files_of(outputs)}};
  }
  if (process == job::diff_process) {
    check_names(inputs, {"first", "second", "tolerance"}, 2);
    json read{{"first", tileset_of(inputs["first"], "/inputs/first", references)},
              {"second", tileset_of(inputs["second"], "/inputs/second", references)},
              {"tolerance", number_of(inputs, "tolerance", 1e6)}};
    if (!wants(outputs, "page")) read["page"] = false;
    return read;
  }
  if (process == echo_process) {
    check_names(inputs, {"echo", "pause"}, 1);
    const double pause = number_of(inputs, "pause", most_pause);
    if (pause > 0 && size > most_paused) {
      refuse("/inputs/pause", fmt::format("must be 0 s with a body of more than {} bytes, of {}",
                                          most_paused, size));
    }
    return {{"echo", std::move(inputs["echo"])}, {"pause", pause}};
  }
  if (process == job::bake_process) return bake_inputs_of(inputs, references);
  check_names(inputs, {"scene"}, 1);
  return {{"scene", scene_of(std::move(inputs["scene"]), references)}};
}

int priority_of(const json& value) {
  const int most = job::most_priority;
  if (!value.is_number_integer() || value < -most || value > most) {
    refuse("/priority", fmt::format("must be an integer in [{}, {}]", -most, most));
  }
  return value.get<int>();
}

/// subscriber.yaml of OGC API - Processes 1.0.
job::Subscriber subscriber_of(const json& value) {
  if (!value.is_object()) refuse("/subscriber", "must be an object");
  job::Subscriber subscriber;
  for (const auto& item : value.items()) {
    const auto pointer = "/subscriber/" + pointer_token(item.key());
    std::string* uri = nullptr;
    if (item.key() == "successUri") uri = &subscriber.success;
    if (item.key() == "inProgressUri") uri = &subscriber.in_progress;
    if (item.key() == "failedUri") uri = &subscriber.failed;
    if (uri == nullptr) refuse(pointer, "is no member of a subscriber");
    if (!item.value().is_string()) refuse(pointer, "must be a string");
    *uri = item.value().get<std::string>();
    http::target_of(*uri, pointer);  // is one that could be called
  }
  if (subscriber.success.empty()) refuse("/subscriber/successUri", "is missing");
  return subscriber;
}

/// Of the draft "The Idempotency-Key HTTP Header Field". Empty when there is none.
std::string key_of(const Request& request) {
  const auto found = request.headers.find("idempotency-key");
  if (found == request.headers.end()) return {};
  const auto& key = found->second;
  const bool plain = std::ranges::all_of(key, [](char c) { return c > ' ' && c <= '~'; });
  if (key.empty() || key.size() > most_key || !plain) {
    refuse(header_place("Idempotency-Key"),
           fmt::format("must be 1 to {} characters of ASCII without spaces", most_key));
  }
  return key;
}

/// execute.yaml of 1.0 with the drafts' processID; anything else is a slip, or a wish that would
/// not come true.
void check_members(std::string_view process, const json& body, const References& references) {
  static const std::set<std::string> known{"inputs",     "outputs",  "response",
                                           "subscriber", "priority", "processID"};
  std::vector<Problem> problems;
  for (const auto& item : body.items()) {
    if (known.contains(item.key())) continue;
    problems.push_back({"/" + pointer_token(item.key()), "is no member of an execution"});
  }
  const auto id = body.value("processID", json(process));
  if (id != process && id != references.base + "/processes/" + std::string(process)) {
    problems.push_back({"/processID", "must be " + std::string(process) + ", as the path says"});
  }
  if (!problems.empty()) throw Error(Fault::bad_input, std::move(problems));
}

}  // namespace

Execution read_execution(std::string_view process, const Request& request,
                         const References& references) {
  auto body = parse(request.body, "");
  if (!body.is_object()) refuse("", "must be an object");
  check_members(process, body, references);
  const auto response = body.value("response", json("document"));
  const bool may_be_raw = control_of(process)->sync;
  if (response != "document" && !(may_be_raw && response == "raw")) {
    refuse("/response", may_be_raw ? "must be \"raw\" or \"document\""
                                   : "must be \"document\": results are given by reference");
  }
  if (!body.contains("inputs")) refuse("/inputs", "is missing");
  if (!body["inputs"].is_object()) refuse("/inputs", "must be an object");
  Execution execution;
  auto& wanted = execution.request;
  wanted.process = process;
  wanted.owner = request.owner;
  wanted.key = key_of(request);
  if (body.contains("priority")) wanted.priority = priority_of(body["priority"]);
  if (body.contains("subscriber")) wanted.subscriber = subscriber_of(body["subscriber"]);
  wanted.outputs = outputs_of(process, body);
  wanted.inputs = inputs_of(process, body, request.body.size(), wanted.outputs, references);
  execution.raw = response == "raw";
  return execution;
}

}  // namespace hoodoo::http
