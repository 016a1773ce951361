#include "engine/dem/window.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "engine/dem/keys.hpp"

namespace hoodoo::dem {
namespace {

constexpr int reach = Window::fill_radius;
constexpr std::size_t few = 17;  // rows of points looked up together

struct Offset {
  int di, dj;
};

// Nearest first; equally near ones in a fixed order, so that a fill depends on nothing else.
std::vector<Offset> nearest_first() {
  std::vector<Offset> offsets;
  for (int dj = -reach; dj <= reach; ++dj) {
    for (int di = -reach; di <= reach; ++di) {
      const int square = di * di + dj * dj;
      if (square > 0 && square <= reach * reach) offsets.push_back({di, dj});
    }
  }
  std::stable_sort(offsets.begin(), offsets.end(), [](const Offset& a, const Offset& b) {
    return a.di * a.di + a.dj * a.dj < b.di * b.di + b.dj * b.dj;
  });
  return offsets;
}

// floor, without the call that std::floor is on the baseline processor. |u| < 2^62.
std::int64_t floor_of(double u) {
  const auto whole = static_cast<std::int64_t>(u);
  return whole - (static_cast<double>(whole) > u ? 1 : 0);
}

// Keeps what comes from outside within what an index holds; a pixel so far away is edge anyhow.
double within_indices(double u) { return std::min(std::max(u, -1e15), 1e15); }

}  // namespace

Window::Window(double x0, double y0, double dx, double dy, std::int64_t i0, std::int64_t j0,
               int width, int height, std::vector<float> samples)
    : x0_(x0),
      y0_(y0),
      per_x_(1 / dx),
      per_y_(1 / dy),
      i0_(i0),
      j0_(j0),
      width_(width),
      height_(height),
      filled_(std::move(samples)) {
  assert(filled_.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  if (std::none_of(filled_.begin(), filled_.end(), [](float h) { return h != h; })) return;
  valid_.resize(filled_.size());
  std::vector<std::size_t> holes;
  for (std::size_t k = 0; k < filled_.size(); ++k) {
    valid_[k] = filled_[k] == filled_[k];
    if (!valid_[k]) holes.push_back(k);
  }
  static const auto offsets = nearest_first();
  for (const auto k : holes) {
    const int i = static_cast<int>(k % static_cast<std::size_t>(width));
    const int j = static_cast<int>(k / static_cast<std::size_t>(width));
    filled_[k] = 0;
    for (const auto& o : offsets) {
      const int p = i + o.di, q = j + o.dj;
      if (p < 0 || q < 0 || p >= width || q >= height || !valid_[index(p, q)]) continue;
      filled_[k] = filled_[index(p, q)];
      break;
    }
  }
}

bool Window::valid(double x, double y) const {
  if (empty()) return false;
  const auto i = floor_of(within_indices((x - x0_) * per_x_)) - i0_;
  const auto j = floor_of(within_indices((y - y0_) * per_y_)) - j0_;
  return i >= 0 && j >= 0 && i < width_ && j < height_ &&
         (valid_.empty() || valid_[index(static_cast<int>(i), static_cast<int>(j))]);
}

void Window::valid(std::span<const double> x, std::span<const double> y,
                   std::span<std::uint8_t> out) const {
  std::fill(out.begin(), out.end(), std::uint8_t{0});
  if (empty()) return;
  std::vector<std::int64_t> columns(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto column = floor_of(within_indices((x[i] - x0_) * per_x_)) - i0_;
    columns[i] = column < width_ ? column : -1;
  }
  for (const double at : y) {
    const auto j = floor_of(within_indices((at - y0_) * per_y_)) - j0_;
    for (std::size_t i = 0; i < x.size() && j >= 0 && j < height_; ++i) {
      if (columns[i] < 0) continue;
      const auto place = static_cast<std::size_t>(j * width_ + columns[i]);
      out[i] = valid_.empty() || valid_[place] ? 1 : 0;
    }
    out = out.subspan(x.size());
  }
}

Window::Stencil Window::stencil(double x, double y) const {
  const double u = within_indices((x - x0_) * per_x_ - 0.5);
  const double v = within_indices((y - y0_) * per_y_ - 0.5);
  const auto i = floor_of(u), j = floor_of(v);
  Stencil s;
  s.fx = u - static_cast<double>(i);
  s.fy = v - static_cast<double>(j);
  const auto column = i - i0_ - 1, row = j - j0_ - 1;
  if (column >= 0 && row >= 0 && column + 4 <= width_ && row + 4 <= height_) {
    const float* const from =
        filled_.data() + index(static_cast<int>(column), static_cast<int>(row));
    for (int k = 0; k < 4; ++k) s.rows[k] = from + static_cast<std::ptrdiff_t>(k) * width_;
    return s;
  }
  // Beyond the window its edge continues.
  for (int k = 0; k < 4; ++k) {
    const auto q = static_cast<int>(std::clamp<std::int64_t>(row + k, 0, height_ - 1));
    for (int l = 0; l < 4; ++l) {
      const auto p = static_cast<int>(std::clamp<std::int64_t>(column + l, 0, width_ - 1));
      s.own[k][l] = filled_[index(p, q)];
    }
    s.rows[k] = nullptr;
  }
  return s;
}

double Window::height(double x, double y) const {
  if (empty()) return 0;
  const auto s = stencil(x, y);
  double wx[4], wy[4], across[4];
  keys_weights(s.fx, wx);
  keys_weights(s.fy, wy);
  for (int k = 0; k < 4; ++k) across[k] = weighted(wx, s.row(k));
  return weighted(wy, across);
}

void Window::grid(std::span<const double> x, std::span<const double> y, const Heights& out) const {
  if (x.empty()) return;
  if (empty()) {
    for (const auto& all : {out.h, out.hx, out.hy}) std::fill(all.begin(), all.end(), 0.0);
    return;
  }
  const auto part = [&](std::span<double> all, std::size_t j, std::size_t n) {
    return all.empty() ? all : all.subspan(x.size() * j, x.size() * n);
  };
  for (std::size_t j = 0; j < y.size(); j += few) {
    const std::size_t n = std::min(few, y.size() - j);
    grid_of_few(x, y.subspan(j, n), {part(out.h, j, n), part(out.hx, j, n), part(out.hy, j, n)});
  }
}

void Window::grid_of_few(std::span<const double> x, std::span<const double> y,
                         const Heights& out) const {
  std::array<SamplePlace, few> rows;
  std::int64_t south = std::numeric_limits<std::int64_t>::max(), north = -south;
  for (std::size_t j = 0; j < y.size(); ++j) {
    const double v = within_indices((y[j] - y0_) * per_y_ - 0.5);
    const auto whole = floor_of(v);
    const auto k = keys(v - static_cast<double>(whole));
    rows[j].first = whole - j0_ - 1;
    std::copy(k.w, k.w + 4, rows[j].w);
    std::copy(k.d, k.d + 4, rows[j].d);
    south = std::min(south, rows[j].first);
    north = std::max(north, rows[j].first + 3);
  }
  const bool slopes = !out.hx.empty();
  if (north - south < static_cast<std::int64_t>(most_rows)) {
    return look_up_grid(samples(), x.data(), x.size(), rows.data(), y.size(), out.h.data(),
                        slopes ? out.hx.data() : nullptr, slopes ? out.hy.data() : nullptr);
  }
  for (std::size_t n = 0; n < x.size() * y.size(); ++n) {
    const Height h = at(x[n % x.size()], y[n / x.size()]);
    out.h[n] = h.h;
    if (slopes) out.hx[n] = h.hx, out.hy[n] = h.hy;
  }
}

Height Window::at(double x, double y) const {
  if (empty()) return {0, 0, 0};
  const auto s = stencil(x, y);
  const auto kx = keys(s.fx), ky = keys(s.fy);
  double across[4], sloping[4];
  for (int k = 0; k < 4; ++k) {
    across[k] = weighted(kx.w, s.row(k));
    sloping[k] = weighted(kx.d, s.row(k));
  }
  return {weighted(ky.w, across), weighted(ky.w, sloping) * per_x_,
          weighted(ky.d, across) * per_y_};
}

/// An index into the samples fits 32 bits.
bool Window::is_small() const {
  return filled_.size() <= std::size_t{std::numeric_limits<std::int32_t>::max()};
}

Samples Window::samples() const {
  return {filled_.data(), x0_, y0_, per_x_, per_y_, i0_, j0_, width_, height_};
}

void Window::heights_at(std::span<const double> x, std::span<const double> y,
                        std::span<double> out) const {
  if (!empty() && is_small()) {
    return look_up(samples(), x.data(), y.data(), x.size(), out.data(), nullptr, nullptr);
  }
  for (std::size_t i = 0; i < x.size(); ++i) out[i] = height(x[i], y[i]);
}

void Window::at(std::span<const double> x, std::span<const double> y, const Heights& out) const {
  if (!empty() && is_small()) {
    return look_up(samples(), x.data(), y.data(), x.size(), out.h.data(), out.hx.data(),
                   out.hy.data());
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Height h = at(x[i], y[i]);
    out.h[i] = h.h;
    out.hx[i] = h.hx;
    out.hy[i] = h.hy;
  }
}

Window::Range Window::involved(const Box& area) const {
  const auto column = [&](double x, int more) {
    const auto i = floor_of(within_indices((x - x0_) * per_x_ - 0.5)) - i0_ + more;
    return static_cast<int>(std::clamp<std::int64_t>(i, 0, width_ - 1));
  };
  const auto row = [&](double y, int more) {
    const auto j = floor_of(within_indices((y - y0_) * per_y_ - 0.5)) - j0_ + more;
    return static_cast<int>(std::clamp<std::int64_t>(j, 0, height_ - 1));
  };
  return {column(area.min.x, -1), row(area.min.y, -1), column(area.max.x, 2), row(area.max.y, 2)};
}

Interval Window::bounds(const Box& area) const {
  if (empty()) return {0, 0};
  const auto range = involved(area);
  const auto [low, high] = extremes(samples(), range.i0, range.j0, range.i1, range.j1);
  return widened(low, high);
}

double Window::slope(const Box& area) const {
  if (empty()) return 0;
  const auto range = involved(area);
  float east = 0, north = 0, size = 0;
  for (int j = range.j0; j <= range.j1; ++j) {
    const float* const row = filled_.data() + index(0, j);
    for (int i = range.i0; i <= range.i1; ++i) {
      size = std::max(size, std::abs(row[i]));
      if (i < range.i1) east = std::max(east, std::abs(row[i + 1] - row[i]));
      if (j < range.j1) north = std::max(north, std::abs(row[i + width_] - row[i]));
    }
  }
  // The derivative of a row is a combination of its three differences whose weights have sizes
  // that sum to 3/2 at most; across rows 5/4 as for the value.
  const double hx = 1.875 * static_cast<double>(east) * per_x_;
  const double hy = 1.875 * static_cast<double>(north) * per_y_;
  const double rounding = 1e-12 * static_cast<double>(size) * (per_x_ + per_y_);
  return std::sqrt(hx * hx + hy * hy) * (1 + 1e-9) + rounding;
}

Interval widened(float low, float high) {
  const double middle = 0.5 * (static_cast<double>(low) + static_cast<double>(high));
  const double half = 0.5 * (static_cast<double>(high) - static_cast<double>(low));
  const double size =
      std::max(std::abs(static_cast<double>(low)), std::abs(static_cast<double>(high)));
  const double reach_of_value = keys_overshoot * half + 1e-12 * size;
  return {middle - reach_of_value, middle + reach_of_value};
}

}  // namespace hoodoo::dem
