#pragma once
#include <algorithm>
#include <cmath>

namespace hoodoo::volume {

/// Bracketed root finding on one lattice edge, t in [0, 1], one evaluation at a time so that many
/// edges can be evaluated in one batch. Never leaves the bracket. Ends when the bracket is within
/// `tolerance`, or when the last evaluation is, by the slopes towards both ends of the bracket;
/// after `most_secants` evaluations it halves the bracket, so that 14 more are enough for any
/// function. Source: Anderson, Bjorck 1973, A new high order method of regula falsi type for
/// computing a root of an equation.
class RootFinder {
 public:
  static constexpr double tolerance = 1e-4;  // in edges
  static constexpr int most_secants = 8;

  RootFinder() = default;
  /// `low` and `high` are the values at t = 0 and t = 1 less the iso value; their signs differ.
  RootFinder(double low, double high) : f_low_(low), f_high_(high) {}

  bool done() const { return done_; }
  double root() const {
    const double secant = (f_high_ * low_ - f_low_ * high_) / (f_high_ - f_low_);
    return std::min(std::max(secant, low_), high_);
  }

  /// Where to evaluate next.
  double next() const { return steps_ < most_secants ? root() : 0.5 * (low_ + high_); }
  /// The value there less the iso value; solid where it is above zero.
  void put(double t, double value) {
    ++steps_;
    const bool is_low = (value > 0) == (f_low_ > 0);
    double &end = is_low ? low_ : high_, &f_end = is_low ? f_low_ : f_high_;
    double& f_kept = is_low ? f_high_ : f_low_;
    const double side = is_low ? -1 : 1, most = 0.5 * tolerance;
    const bool near_end = std::abs(value) * std::abs(t - end) <= most * std::abs(value - f_end);
    // The end that stays put twice counts for less, which makes the next secant fall beyond the
    // root.
    const double ratio = 1 - value / f_end;
    if (side_ == side) f_kept *= ratio > 0 && ratio < 1 ? ratio : 0.5;
    side_ = side;
    end = t;
    f_end = value;
    const double width = high_ - low_;
    const bool near_both = near_end && std::abs(value) * width <= most * std::abs(f_high_ - f_low_);
    done_ = width <= tolerance || near_both;
  }

 private:
  double low_ = 0, high_ = 1, f_low_ = -1, f_high_ = 1;
  double side_ = 0;  // the end that the last evaluation took the place of: -1 low, 1 high
  int steps_ = 0;
  bool done_ = false;
};

}  // namespace hoodoo::volume
