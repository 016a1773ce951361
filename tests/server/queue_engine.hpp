#pragma once
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "engine/base/file.hpp"
#include "server/job/queue.hpp"
#include "tests/server/temporary_folder.hpp"

namespace hoodoo {

/// A scene that has no problems.
inline nlohmann::json good_scene() { return {{"hoodoo", 1}, {"name", "hill"}}; }

/// A request to bake it.
inline job::Request bake_of(const nlohmann::json& scene) {
  return {std::string(job::bake_process), {{"scene", scene}}, 0, "", ""};
}

/// Bakes no terrain: takes any scene but {"bad": ...}, and does `run` for each job.
inline job::Engine engine_of(std::function<job::Outcome(const job::Work&)> run) {
  return {[](const std::filesystem::path& file) {
            std::vector<Problem> problems;
            if (nlohmann::json::parse(read_file(file, 1u << 20)).contains("bad")) {
              problems = {{"/bad", "is an unknown key"}};
            }
            return problems;
          },
          std::move(run)};
}

/// Waits for a stop request as a bake does, then throws what a bake throws.
inline job::Outcome until_stopped(const job::Work& work) {
  while (!work.stop.stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  throw Error(Fault::cancelled, "", "stopped");
}

inline job::Outcome finished() {
  job::Outcome outcome;
  outcome.complete = true;
  outcome.progress.phase = bake::Progress::Phase::done;
  outcome.progress.done = outcome.progress.total = 3;
  return outcome;
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

/// Of a queue whose data are in `folder`.
inline job::Settings settings_in(const TemporaryFolder& folder) {
  job::Settings settings;
  settings.data = folder.path / "data";
  return settings;
}

}  // namespace hoodoo
