#pragma once
#include <chrono>
#include <functional>
#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "server/job/job.hpp"

namespace hoodoo {

/// A scene that has no problems.
inline nlohmann::json good_scene() { return {{"hoodoo", 1}, {"name", "hill"}}; }

/// Bakes no terrain: takes any scene but {"bad": ...}, and does `bake` for each job.
inline job::Engine engine_of(
    std::function<bake::Report(const std::filesystem::path&, const bake::Settings&)> bake) {
  return {[](const nlohmann::json& scene, const scene::Sources&) {
            std::vector<Problem> problems;
            if (scene.contains("bad")) problems = {{"/bad", "is an unknown key"}};
            return problems;
          },
          [bake = std::move(bake)](
              const nlohmann::json&, const scene::Sources&, const std::filesystem::path& folder,
              const bake::Settings& settings) { return bake(folder, settings); }};
}

/// Waits for a stop request as a bake does, then throws what a bake throws.
inline bake::Report until_stopped(const bake::Settings& settings) {
  while (!settings.stop.stop_requested()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  throw Error(Fault::cancelled, "", "stopped");
}

inline bake::Report finished() {
  bake::Report report;
  report.complete = true;
  report.progress.phase = bake::Progress::Phase::done;
  report.progress.done = report.progress.total = 3;
  return report;
}

/// The job once it has `status`; fails the test's patience after ten seconds.
inline job::Job wait_for(const job::Queue& queue, const std::string& id, job::Status status) {
  for (int i = 0; i < 10'000; ++i) {
    const auto job = queue.find(id);
    if (job && job->status == status) return *job;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  throw std::runtime_error("the job does not get there");
}

}  // namespace hoodoo
