#pragma once
#include <algorithm>
#include <cmath>

namespace hoodoo::volume {

/// Bracketed root finding on one lattice edge, t in [0, 1], one evaluation at a time so that many
/// edges can be evaluated in one batch. Never leaves the bracket; ends within `tolerance` after at
/// most one evaluation more than bisection would take.
/// Source: Oliveira, Takahashi 2021, An Enhancement of the Bisection Method Average Performance
/// Preserving Minmax Optimality (ITP), with kappa_1 = 0.2, kappa_2 = 2, n_0 = 1.
class RootFinder {
 public:
  static constexpr double tolerance = 1e-4;  // width of the last bracket, in edges
  /// 2^(n_1/2 + n_0) for a bracket of 1 and the tolerance above; halved at each step.
  static constexpr double first_room = 32768;

  RootFinder() = default;
  /// `low` and `high` are the values at t = 0 and t = 1 less the iso value; their signs differ.
  RootFinder(double low, double high) : f_low_(low), f_high_(high) {}

  bool done() const { return high_ - low_ <= tolerance; }
  double root() const { return 0.5 * (low_ + high_); }

  /// Where to evaluate next.
  double next() const {
    const double middle = 0.5 * (low_ + high_), width = high_ - low_;
    const double reach = 0.5 * tolerance * room_ - 0.5 * width;
    const double slack = 0.2 * width * width;
    const double secant = (f_high_ * low_ - f_low_ * high_) / (f_high_ - f_low_);
    const double side = middle >= secant ? 1 : -1;
    const double truncated = slack <= std::abs(middle - secant) ? secant + side * slack : middle;
    return std::abs(truncated - middle) <= reach ? truncated : middle - side * std::max(reach, 0.0);
  }
  /// The value there less the iso value; solid where it is above zero.
  void put(double t, double value) {
    room_ *= 0.5;
    if ((value > 0) == (f_low_ > 0)) {
      low_ = t;
      f_low_ = value;
    } else {
      high_ = t;
      f_high_ = value;
    }
  }

 private:
  double low_ = 0, high_ = 1, f_low_ = -1, f_high_ = 1;
  double room_ = first_room;
};

}  // namespace hoodoo::volume
