#include "engine/base/math.hpp"

#include <cmath>
#include <limits>

namespace hoodoo {
namespace {

/// hi + lo, lo below half a unit of hi's last place.
struct Pair {
  double hi, lo;
};

/// a * b without error (Dekker 1971); |a|, |b| < 1e150.
Pair product(double a, double b) {
  constexpr double split = 134217729;  // 2^27 + 1
  const double ca = split * a, cb = split * b;
  const double ah = ca - (ca - a), al = a - ah, bh = cb - (cb - b), bl = b - bh;
  const double p = a * b;
  return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}

/// a + b without error.
Pair sum_of(double a, double b) {
  const double s = a + b;
  return {s, std::abs(a) > std::abs(b) ? (a - s) + b : (b - s) + a};
}

// pi/2 and ln 2 in pieces short enough that a piece times a whole number below 2^20 is exact
// (fdlibm, e_rem_pio2.c and e_log.c).
constexpr double half_pi_1 = 1.57079632673412561417e+00;
constexpr double half_pi_2 = 6.07710050630396597660e-11;
constexpr double half_pi_3 = 2.02226624871116645580e-21;
constexpr double half_pi_4 = 8.47842766036889956997e-32;
constexpr double ln2_1 = 6.93147180369123816490e-01;
constexpr double ln2_2 = 1.90821492927058770002e-10;

/// sin on [-pi/4, pi/4]; fdlibm, k_sin.c.
double kernel_sin(double x) {
  const double z = x * x;
  const double tail = 8.33333333332248946124e-03 +
                      z * (-1.98412698298579493134e-04 +
                           z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 +
                                                                  z * 1.58969099521155010221e-10)));
  return x + x * z * (-1.66666666666666324348e-01 + z * tail);
}

/// cos on [-pi/4, pi/4]; fdlibm, k_cos.c.
double kernel_cos(double x) {
  const double z = x * x;
  const double tail =
      z * (4.16666666666666019037e-02 +
           z * (-1.38888888888741095749e-03 +
                z * (2.48015872894767294178e-05 +
                     z * (-2.75573143513906633035e-07 +
                          z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
  const double half = 0.5 * z, w = 1 - half;
  return w + (((1 - w) - half) + z * tail);
}

/// sin(x + turns * pi/2).
double turned_sin(double x, int turns) {
  const double k = std::floor(x * (2 / pi) + 0.5);
  const double r = ((x - k * half_pi_1) - k * half_pi_2) - k * half_pi_3 - k * half_pi_4;
  switch ((static_cast<long>(k) + turns) & 3) {
    case 0:
      return kernel_sin(r);
    case 1:
      return kernel_cos(r);
    case 2:
      return -kernel_sin(r);
    default:
      return -kernel_cos(r);
  }
}

/// exp(x.hi + x.lo). fdlibm, e_exp.c.
double exp_of(const Pair& x) {
  if (x.hi > 710) return std::numeric_limits<double>::infinity();
  if (x.hi < -746) return 0;
  const double k = std::floor(x.hi * (1 / (ln2_1 + ln2_2)) + 0.5);
  const double hi = x.hi - k * ln2_1, lo = k * ln2_2 - x.lo, r = hi - lo, z = r * r;
  const double c =
      r - z * (1.66666666666666019037e-01 +
               z * (-2.77777777770155933842e-03 +
                    z * (6.61375632143793436117e-05 +
                         z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08))));
  return std::ldexp(1 - ((lo - (r * c) / (2 - c)) - hi), static_cast<int>(k));
}

/// log(x) with a relative error near 1e-18: 2 atanh(s), s = (m - 1) / (m + 1), x = m 2^k.
Pair log_of(double x) {
  int k = 0;
  double m = std::frexp(x, &k);
  if (m < 0.70710678118654752440) {
    m *= 2;
    --k;
  }
  const double f = m - 1, g = m + 1, g_lost = (1 - g) + m;
  const double s = f / g;
  const Pair back = product(s, g);
  const double s_lost = (((f - back.hi) - back.lo) - s * g_lost) / g;
  const double z = s * s;
  double series = 0;
  for (int n = 27; n >= 3; n -= 2) series = z * series + 2.0 / n;
  const double tail = 2 * s_lost + s * z * series;
  // k ln 2 + 2 s + tail, the roundings kept.
  const Pair sum = sum_of(k * ln2_1, 2 * s);
  return sum_of(sum.hi, sum.lo + (k * ln2_2 + tail));
}

}  // namespace

double bit_sin(double radians) { return turned_sin(radians, 0); }

double bit_cos(double radians) { return turned_sin(radians, 1); }

double bit_exp(double x) { return exp_of({x, 0}); }

double bit_log(double x) {
  const Pair l = log_of(x);
  return l.hi + l.lo;
}

double bit_pow(double base, double x) {
  if (x == 0 || base == 1) return 1;
  if (base == 0) return x > 0 ? 0 : std::numeric_limits<double>::infinity();
  const Pair l = log_of(base);
  if (std::abs(x) > 1e150 || std::abs(x * l.hi) > 1000) return exp_of({x * l.hi, 0});
  const Pair p = product(x, l.hi);
  return exp_of(sum_of(p.hi, p.lo + x * l.lo));
}

}  // namespace hoodoo
