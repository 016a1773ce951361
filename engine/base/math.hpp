#pragma once

namespace hoodoo {

/// Transcendental functions from multiplications, additions, divisions and square roots alone, so
/// that they give the same bits with every compiler, C library and processor.
/// Relative error below 1e-14; |x| <= 1e6 for the circular ones.
double bit_sin(double radians);
double bit_cos(double radians);
double bit_exp(double x);
double bit_log(double x);               // x > 0
double bit_pow(double base, double x);  // base >= 0

inline constexpr double pi = 3.14159265358979323846;

}  // namespace hoodoo
