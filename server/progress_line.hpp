#pragma once
#include <chrono>
#include <string>
#include <vector>

#include "tiling/bake/bake.hpp"

namespace hoodoo {

/// Shows how far a bake is on stderr: a bar that redraws itself on a terminal, plain lines every
/// few seconds in a pipe, or a line of JSON ten times a second for a program.
class ProgressLine {
 public:
  enum class Style { bar, lines, json, off };
  /// `automatic`: a bar on a terminal, else lines.
  static Style automatic();

  explicit ProgressLine(Style style) : style_(style) {}
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(const bake::Progress& progress);

 private:
  using Clock = std::chrono::steady_clock;
  std::string text(const bake::Progress& progress) const;
  void tell(const bake::Progress& progress);

  Style style_;
  Clock::time_point tiles_started_{}, shown_{};
  bake::Progress::Phase phase_ = bake::Progress::Phase::ingest;
  bool drawn_ = false;
  std::vector<bake::FinishedTile> waiting_;  // to be told, the newest
};

}  // namespace hoodoo
