#include "server/progress_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "server/job/state.hpp"

namespace hoodoo {
namespace {

using Phase = bake::Progress::Phase;

std::string bar(double part) {
  constexpr int width = 24;
  const int full = static_cast<int>(std::clamp(part, 0.0, 1.0) * width);
  return fmt::format("[{:#<{}}{:.<{}}]", "", full, "", width - full);
}

std::string duration(double seconds) {
  const auto s = static_cast<long>(seconds + 0.5);
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{}:{:02} min", s / 60, s % 60);
  return fmt::format("{}:{:02} h", s / 3600, s / 60 % 60);
}

}  // namespace

ProgressLine::Style ProgressLine::automatic() {
  return ::isatty(STDERR_FILENO) != 0 ? Style::bar : Style::lines;
}

ProgressLine::~ProgressLine() {
  if (drawn_) std::fputs("\n", stderr);
}

std::string ProgressLine::text(const bake::Progress& p) const {
  if (p.phase == Phase::ingest) {
    return fmt::format("elevations {} {:3.0f} %", bar(p.ingest), 100 * p.ingest);
  }
  if (p.phase != Phase::tiles) return "measuring errors, writing the index";
  const double part = p.total == 0 ? 1 : static_cast<double>(p.done) / static_cast<double>(p.total);
  auto line = fmt::format("tiles {} {}/{}", bar(part), p.done, p.total);
  const auto baked = p.done - p.reused - p.cached;
  const double elapsed = std::chrono::duration<double>(Clock::now() - tiles_started_).count();
  if (baked > 0 && elapsed > 0.2) {
    const double rate = static_cast<double>(baked) / elapsed;
    line += fmt::format(", {:.1f}/s", rate);
    line += ", " + duration(static_cast<double>(p.total - p.done) / rate) + " left";
  }
  if (p.reused > 0) line += fmt::format(", {} found finished", p.reused);
  if (p.cached > 0) line += fmt::format(", {} from the cache", p.cached);
  return line;
}

void ProgressLine::tell(const bake::Progress& p) {
  auto told = p;
  told.finished = std::exchange(waiting_, {});
  fmt::print(stderr, "{}\n", job::to_json(told).dump());
}

void ProgressLine::show(const bake::Progress& p) {
  if (style_ == Style::json) {
    waiting_.insert(waiting_.end(), p.finished.begin(), p.finished.end());
    const auto over = std::max(waiting_.size(), job::most_told) - job::most_told;
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(over));
  }
  const auto now = Clock::now();
  const bool new_phase = p.phase != phase_;
  if (new_phase && p.phase == Phase::tiles) tiles_started_ = now;
  phase_ = p.phase;
  if (style_ == Style::off || p.phase == Phase::done) return;
  const auto pause =
      style_ == Style::lines ? std::chrono::milliseconds(5000) : std::chrono::milliseconds(100);
  const bool last = p.phase == Phase::tiles && p.done == p.total;
  if (!new_phase && !last && now - shown_ < pause) return;
  shown_ = now;
  if (style_ == Style::bar) {
    fmt::print(stderr, "\r{}\x1b[K", text(p));
    std::fflush(stderr);
    drawn_ = true;
  } else if (style_ == Style::json) {
    tell(p);
  } else {
    fmt::print(stderr, "{}\n", text(p));
  }
}

}  // namespace hoodoo
