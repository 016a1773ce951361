#include "engine/scene/picture.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/scene/ball_files.hpp"
#include "engine/scene/voxel_files.hpp"
#include "engine/tree/evaluate.hpp"
#include "engine/tree/parse.hpp"

namespace hoodoo::scene {
namespace {

using tree::Family;

constexpr double usual_half = 12;                  // [m] of the cube, where a tree has no end
constexpr std::size_t samples = tree::batch_size;  // along a ray
constexpr std::array<double, 3> paper{250, 249, 246};
constexpr std::array<double, 3> rock{206, 168, 122};
constexpr std::array<double, 3> inside{150, 92, 66};  // where a face of the cube cuts the solid

/// A parallel camera that sees the west, the south and the upper face of a cube.
struct Camera {
  Vec3 forward = normalized(Vec3{0.62, 0.74, -0.56});
  Vec3 right = normalized(cross(forward, Vec3{0, 0, 1}));
  Vec3 up = cross(right, forward);
};

/// The part of a ray in [-half, half]^3, and the axis of the face where it enters.
struct Span {
  double from, to;
  int axis;
};
std::optional<Span> span_of(const Vec3& start, const Vec3& along, double half) {
  Span span{-1e30, 1e30, 0};
  for (int axis = 0; axis < 3; ++axis) {
    double a = (-half - start[axis]) / along[axis], b = (half - start[axis]) / along[axis];
    if (a > b) std::swap(a, b);
    if (a > span.from) {
      span.from = a;
      span.axis = axis;
    }
    span.to = std::min(span.to, b);
  }
  if (span.from < span.to) return span;
  return std::nullopt;
}

std::uint8_t byte(double v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0, 255.0)); }

/// Light on a surface from the upper left, and from everywhere.
double light_on(const Vec3& normal) {
  static const Vec3 sun = normalized(Vec3{-0.75, -0.35, 0.9});
  return 0.42 + 0.62 * std::max(0.0, dot(normal, sun));
}

class Drawing {
 public:
  Drawing(const tree::Node& tree, Family family, int size) : family_(family) {
    const Box box = tree::support(tree).influence;
    const Vec3 extent = box.max - box.min;
    const double longest = std::max({extent.x, extent.y, extent.z});
    const bool bounded = !box.empty() && std::isfinite(longest);
    half_ = bounded ? 0.51 * longest : usual_half;
    center_ = bounded ? (box.min + box.max) * 0.5 : Vec3{};
    const Vec3 h{half_, half_, half_};
    compiled_ = tree::compile(tree, {center_, {center_ - h, center_ + h}});
    picture_.size = size;
    picture_.rgb.reserve(3 * static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  }

  Picture draw() {
    for (int j = 0; j < picture_.size; ++j) {
      for (int i = 0; i < picture_.size; ++i) {
        for (const double v : pixel(i, j)) picture_.rgb.push_back(byte(v));
      }
    }
    return std::move(picture_);
  }

 private:
  std::array<double, 3> pixel(int i, int j) {
    const double scale = 1.75 * half_ / (0.5 * picture_.size);
    const double u = (i + 0.5 - 0.5 * picture_.size) * scale;
    const double v = (0.5 * picture_.size - j - 0.5) * scale;
    const Vec3 start = camera_.right * u + camera_.up * v - camera_.forward * (4 * half_);
    const auto span = span_of(start, camera_.forward, half_);
    if (!span) return paper;
    return family_ == Family::geology ? face(start, *span) : surface(start, *span);
  }

  std::array<double, 3> face(const Vec3& start, const Span& span) {
    const double rho = values(start, span.from, span.from)[0];
    Vec3 normal;
    normal[span.axis] = camera_.forward[span.axis] > 0 ? -1 : 1;
    const double light = light_on(normal), t = std::clamp(rho, 0.0, 1.0);
    return {light * (70 + 180 * t), light * (52 + 165 * t), light * (44 + 130 * t)};
  }

  std::array<double, 3> surface(const Vec3& start, const Span& span) {
    const auto& f = values(start, span.from, span.to);
    if (f[0] > 0.5) {
      Vec3 normal;
      normal[span.axis] = camera_.forward[span.axis] > 0 ? -1 : 1;
      return lit(inside, normal);
    }
    const double step = (span.to - span.from) / (samples - 1);
    for (std::size_t k = 1; k < samples; ++k) {
      if (!(f[k] > 0.5)) continue;
      // A little before the surface, where a distance of 0 has a direction, too.
      const double part = 0.95 * (0.5 - f[k - 1]) / (f[k] - f[k - 1]);
      return lit(rock,
                 normal_at(start + camera_.forward *
                                       (span.from + (static_cast<double>(k) - 1 + part) * step)));
    }
    return paper;
  }

  static std::array<double, 3> lit(const std::array<double, 3>& colour, const Vec3& normal) {
    const double light = light_on(normal);
    return {colour[0] * light, colour[1] * light, colour[2] * light};
  }

  /// The tree at `samples` points of a ray.
  const std::array<float, samples>& values(const Vec3& start, double from, double to) {
    for (std::size_t k = 0; k < samples; ++k) {
      const Vec3 p =
          start + camera_.forward * (from + (to - from) * static_cast<double>(k) / (samples - 1));
      x_[k] = static_cast<float>(p.x);
      y_[k] = static_cast<float>(p.y);
      z_[k] = static_cast<float>(p.z);
    }
    out_.fill(0);
    if (compiled_.kernel) compiled_.kernel->values({x_, y_, z_}, out_);
    return out_;
  }

  Vec3 normal_at(const Vec3& p) {
    const std::array x{static_cast<float>(p.x)}, y{static_cast<float>(p.y)},
        z{static_cast<float>(p.z)};
    std::array<float, 1> value{}, gx{}, gy{}, gz{};
    compiled_.kernel->gradients({x, y, z}, value, {gx, gy, gz});
    const Vec3 outward{-static_cast<double>(gx[0]), -static_cast<double>(gy[0]),
                       -static_cast<double>(gz[0])};
    return length(outward) > 0 ? normalized(outward) : camera_.up;
  }

  Family family_;
  Camera camera_;
  double half_ = usual_half;
  Vec3 center_;
  tree::Compiled compiled_;
  Picture picture_;
  std::array<float, samples> x_{}, y_{}, z_{}, out_{};
};

}  // namespace

Picture draw(const tree::Node& tree, Family family, int size) {
  return Drawing(tree, family, size).draw();
}

tree::Node read_tree(const nlohmann::json& json, Family family,
                     const std::filesystem::path& folder) {
  const Sources sources{folder, {}};
  Findings findings;
  VoxelFiles grids(sources, findings);
  tree::Context context;
  context.read_voxels = [&](const auto&... names) { return grids.read(names...); };
  BallFiles balls(sources, findings);
  context.check_balls = [&](const auto&... names) { return balls.check(names...); };
  auto& problems = findings.problems;
  auto node = tree::parse_node(json, "", family, context, problems);
  if (node) {
    tree::for_each_point(*node, [&](tree::Point& point) {
      if (point.form != tree::Point::Form::fixed) {
        problems.push_back({"", "must have points as [x, y, z]: there is no ground"});
      }
    });
  }
  findings.report();
  BallLoader(balls.take(), {}, SIZE_MAX, 0).load(*node);
  return std::move(*node);
}

std::vector<unsigned char> png(const Picture& picture) {
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto output = OIIO::ImageOutput::create("png");
  const auto fail = [&](const std::string& why) {
    throw Error(Fault::internal, "", "a PNG cannot be made: " + why);
  };
  if (!output) fail("OpenImageIO has none");
  const OIIO::ImageSpec spec(picture.size, picture.size, 3, OIIO::TypeDesc::UINT8);
  if (!output->set_ioproxy(&memory) || !output->open("picture.png", spec) ||
      !output->write_image(OIIO::TypeDesc::UINT8, picture.rgb.data()) || !output->close()) {
    fail(output->geterror());
  }
  return bytes;
}

void write_png(const Picture& picture, const std::filesystem::path& file) {
  const auto bytes = png(picture);
  write_file(file, std::as_bytes(std::span(bytes)));
}

}  // namespace hoodoo::scene
