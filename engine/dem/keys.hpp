#pragma once

namespace hoodoo::dem {

/// Cubic convolution with a = -1/2 (Keys 1981, Cubic convolution interpolation for digital image
/// processing): weights of the samples at -1, 0, 1, 2 for a point at `f` in [0, 1), and the
/// derivatives of the weights. They are exact at f = 0; the sum of their sizes is at most 5/4.
struct KeysWeights {
  double w[4];
  double d[4];
};

inline void keys_weights(double f, double (&w)[4]) {
  const double g = f * f;
  w[0] = f * (f - 0.5 - 0.5 * g);
  w[1] = 1 + g * (1.5 * f - 2.5);
  w[2] = f * (0.5 + 2 * f - 1.5 * g);
  w[3] = g * (0.5 * f - 0.5);
}

inline KeysWeights keys(double f) {
  KeysWeights k;
  keys_weights(f, k.w);
  const double g = f * f;
  k.d[0] = 2 * f - 0.5 - 1.5 * g;
  k.d[1] = 4.5 * g - 5 * f;
  k.d[2] = 0.5 + 4 * f - 4.5 * g;
  k.d[3] = 1.5 * g - f;
  return k;
}

/// The weighted mean of four samples, always in the same order.
template <class T>
double weighted(const double (&w)[4], const T* s) {
  return w[0] * static_cast<double>(s[0]) + w[1] * static_cast<double>(s[1]) +
         w[2] * static_cast<double>(s[2]) + w[3] * static_cast<double>(s[3]);
}

/// |interpolated - middle of the stencil| is at most this times half the stencil's range, for the
/// plane: (5/4)^2.
inline constexpr double keys_overshoot = 1.5625;

}  // namespace hoodoo::dem
