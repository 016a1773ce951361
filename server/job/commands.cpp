#include "server/job/commands.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <condition_variable>
#include <csignal>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>

#include "engine/base/json.hpp"
#include "server/job/state.hpp"

namespace hoodoo::job {
namespace {

using nlohmann::json;
using Arguments = std::vector<std::string>;

/// The command's own words for why it failed: {"fault": "io", "problems": [{"where", "what"}]}.
[[noreturn]] void fail(const Ended& ended) {
  if (ended.stopped) throw Error(Fault::cancelled, "", "stopped");
  if (ended.signal == SIGXCPU) {
    throw Error(Fault::limit, "", "took more processor time than a job may");
  }
  if (ended.signal != 0) {
    throw Error(Fault::internal, "", fmt::format("was ended by signal {}", ended.signal));
  }
  auto fault = Fault::internal;
  std::vector<Problem> problems;
  try {
    const auto told = parse_json(ended.last_line, "");
    fault = fault_of(told.at("fault").get<std::string>());
    for (const auto& problem : told.at("problems")) {
      problems.push_back({problem.at("where"), problem.at("what")});
    }
  } catch (const std::exception&) {
    problems.clear();
  }
  if (problems.empty()) {
    throw Error(Fault::internal, "", fmt::format("ended with code {}", ended.code));
  }
  throw Error(fault, std::move(problems));
}

/// Its report; `different` is an exit code that is no failure.
json report_of(const Ended& ended, int different = 0) {
  if (ended.signal != 0 || (ended.code != 0 && ended.code != different)) fail(ended);
  try {
    return parse_json(ended.output, "");
  } catch (const Error&) {
    throw Error(Fault::internal, "", "gave no report");
  }
}

/// A process that something else killed, be it the kernel for want of memory or somebody by hand,
/// is started again: what it had finished stays, and the same bytes come of it.
Ended run_on(const Commands& commands, const Arguments& arguments, const Work& work,
             const std::function<void(std::string_view line)>& on_line = {}) {
  constexpr int most_starts = 3;
  for (int start = 1;; ++start) {
    auto ended = run_child(arguments, commands.limits, work.stop, on_line);
    if (ended.signal != SIGKILL || ended.stopped || start == most_starts) return ended;
  }
}

void add_sources(const Commands& commands, Arguments& arguments) {
  if (commands.roots.empty()) return;
  arguments.insert(arguments.end(), {"--base", commands.roots.front().string()});
  for (const auto& root : commands.roots) {
    arguments.insert(arguments.end(), {"--root", root.string()});
  }
}

Outcome bake(const Commands& commands, const Work& work) {
  Arguments arguments{commands.program,
                      "--json",
                      "bake",
                      (work.folder / "scene.json").string(),
                      "-o",
                      (work.folder / "out").string(),
                      "--progress",
                      "json",
                      "--live-index",
                      "500",
                      "--threads",
                      std::to_string(commands.threads),
                      "--memory",
                      std::to_string(commands.memory >> 20)};
  if (work.bounds.tiles) {
    arguments.insert(arguments.end(), {"--most-tiles", std::to_string(*work.bounds.tiles)});
  }
  if (work.bounds.extent) {
    arguments.insert(arguments.end(), {"--most-extent", fmt::format("{}", *work.bounds.extent)});
  }
  add_sources(commands, arguments);
  if (!commands.cache.empty()) {
    arguments.insert(arguments.end(), {"--cache", commands.cache.string()});
  }
  const auto on_line = [&](std::string_view line) {
    try {
      work.progress(progress_from(parse_json(line, "")));
    } catch (const Error&) {  // a warning, or the last line, which tells why it failed
    }
  };
  const auto all = arguments.size();
  if (!work.reuse.empty()) arguments.insert(arguments.end(), {"--reuse", work.reuse.string()});
  auto ended = run_on(commands, arguments, work, on_line);
  std::error_code error;
  const bool base_gone =
      !work.reuse.empty() && !std::filesystem::exists(work.reuse / "bake.json", error);
  if (base_gone && ended.code != 0 && !ended.stopped) {
    arguments.resize(all);
    ended = run_on(commands, arguments, work, on_line);
  }
  const auto report = report_of(ended);
  Outcome outcome;
  auto& progress = outcome.progress;
  progress.phase = bake::Progress::Phase::done;
  progress.ingest = 1;
  report.at("tiles").get_to(progress.done);
  report.at("planned").get_to(progress.total);
  report.at("reused").get_to(progress.reused);
  report.at("cached").get_to(progress.cached);
  report.at("triangles").get_to(progress.triangles);
  report.at("bytes").get_to(progress.bytes);
  report.at("complete").get_to(outcome.complete);
  report.at("warnings").get_to(outcome.warnings);
  return outcome;
}

/// A process that tells no progress: finished, or not.
Outcome finished(json report) {
  Outcome outcome;
  outcome.progress.phase = bake::Progress::Phase::done;
  outcome.progress.ingest = 1;
  outcome.complete = true;
  outcome.report = std::make_shared<const json>(std::move(report));
  return outcome;
}

Outcome analyze(const Commands& commands, const Work& work) {
  const auto out = work.folder / "out";
  std::filesystem::create_directories(out);
  Arguments arguments{commands.program, "--json",
                      "analyze",        work.inputs.at("dem").get<std::string>(),
                      "--memory",       std::to_string(commands.memory >> 20)};
  for (const auto& output : work.inputs.at("outputs")) {
    const auto name = output.get<std::string>();
    const auto* ending = name == "sinks" ? ".csv" : ".tif";
    arguments.insert(arguments.end(), {"--" + name, (out / (name + ending)).string()});
  }
  arguments.insert(arguments.end(), {"--routing", work.inputs.at("routing").get<std::string>()});
  auto report = report_of(run_on(commands, arguments, work));
  report.erase("written");  // names of this machine
  return finished(std::move(report));
}

Outcome diff(const Commands& commands, const Work& work) {
  Arguments arguments{commands.program,
                      "--json",
                      "diff",
                      work.inputs.at("first").get<std::string>(),
                      work.inputs.at("second").get<std::string>(),
                      "--tolerance",
                      fmt::format("{}", work.inputs.at("tolerance").get<double>())};
  if (work.inputs.value("page", true)) {
    const auto page = work.folder / "out" / "diff.html";
    std::filesystem::create_directories(page.parent_path());
    arguments.insert(arguments.end(), {"--html", page.string()});
  }
  constexpr int different = 1;
  return finished(report_of(run_on(commands, arguments, work), different));
}

/// For clients under test: gives back what it is given, after a pause.
Outcome echo(const Work& work) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  const std::chrono::duration<double> pause(work.inputs.at("pause").get<double>());
  std::condition_variable_any().wait_for(lock, work.stop, pause, [] { return false; });
  if (work.stop.stop_requested()) throw Error(Fault::cancelled, "", "stopped");
  return finished({{"echo", work.inputs.at("echo")}});
}

}  // namespace

std::vector<Problem> Commands::check(const std::filesystem::path& file) const {
  Arguments arguments{program, "--json", "check", file.string()};
  add_sources(*this, arguments);
  // Whoever sends a scene waits for this, and others for their turn.
  auto least = limits;
  if (least.processor.count() == 0) least.processor = most_processor_of_check;
  least.processor = std::min(least.processor, most_processor_of_check);
  const auto ended = run_child(arguments, least, {}, {});
  if (ended.signal == SIGXCPU) {
    throw Error(Fault::limit, "",
                fmt::format("takes more than {} s of processor time to look at, which is the limit",
                            least.processor.count()));
  }
  constexpr int problems_found = 2;
  if (ended.output.empty()) fail(ended);
  std::vector<Problem> problems;
  const auto report = report_of(ended, problems_found);
  for (const auto& problem : report.at("problems")) {
    problems.push_back({problem.at("where"), problem.at("what")});
  }
  return problems;
}

Outcome Commands::run(const Work& work) const {
  if (work.process == analyze_process) return analyze(*this, work);
  if (work.process == diff_process) return diff(*this, work);
  if (work.process == bake_process) return bake(*this, work);
  return echo(work);
}

}  // namespace hoodoo::job
