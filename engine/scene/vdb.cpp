// Layout of the file: OpenVDB 10, openvdb/io/Archive.cc, io/GridDescriptor.cc, io/Compression.h and
// the readTopology and readBuffers of tree/. Its own readers believe the lengths that a file states
// and build the whole tree before it can be measured, so that only its maps and masks are used
// here.
#include "engine/scene/vdb.hpp"

#include <blosc.h>
#include <fmt/format.h>
#include <openvdb/io/Compression.h>
#include <openvdb/math/Transform.h>
#include <openvdb/openvdb.h>
#include <openvdb/util/NodeMasks.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/scene/vdb_file.hpp"

namespace hoodoo::scene {
namespace {

namespace io = openvdb::io;
using namespace vdb;
using tree::Voxel;
using tree::Voxels;

constexpr std::array<std::string_view, 7> affine_maps = {
    "AffineMap",      "ScaleMap",        "ScaleTranslateMap",
    "TranslationMap", "UniformScaleMap", "UniformScaleTranslateMap",
    "UnitaryMap"};

/// Index to world, of a grid whose metadata have been passed.
Voxels::Placement read_placement(Source& from) {
  const auto place = from.place();
  const auto map = from.text();
  if (std::find(affine_maps.begin(), affine_maps.end(), map) == affine_maps.end()) {
    refuse(fmt::format("has a transform that is no affine map: \"{}\"", map.substr(0, 80)));
  }
  from.seek(place);
  openvdb::math::Transform transform;
  transform.read(from.stream());
  const auto matrix = transform.baseMap()->getAffineMap()->getMat4();  // of row vectors
  Voxels::Placement made;
  double largest = 0;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const double v = matrix(c, r);
      made.linear[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] = v;
      largest = std::max(largest, std::abs(v));
      if (!std::isfinite(v)) damaged();
    }
    made.shift[r] = matrix(3, r);
    if (!(std::abs(made.shift[r]) <= tree::farthest)) {
      refuse(fmt::format("has a transform beyond {} units", tree::farthest));
    }
  }
  const double volume = std::abs(matrix.getMat3().det());
  if (!(largest <= tree::longest) || !(volume >= 1e-18) ||
      !(volume >= 1e-9 * largest * largest * largest)) {
    refuse("has a transform whose voxels are flat, smaller than 1e-6 or larger than 1e5");
  }
  return made;
}

/// Reads one tree.
class TreeReader {
 public:
  TreeReader(Source& from, std::uint32_t compression, bool as_half, std::size_t voxels_left)
      : from_(from),
        half_(as_half),
        limit_(voxels_left),
        compression_(compression),
        buffer_(32768) {}

  Voxels read(const Voxels::Placement& placement) {
    if (from_.get<std::int32_t>() != 1) damaged();  // buffers per leaf
    background_ = finite(from_.get<float>());
    const auto tiles = from_.get<std::uint32_t>(), children = from_.get<std::uint32_t>();
    for (std::uint32_t i = 0; i < tiles; ++i) {
      spend(16);
      const Voxel at = corner();
      const auto value = from_.get<float>();
      tile(at, 2, value, from_.get<char>() != 0);
    }
    for (std::uint32_t i = 0; i < children; ++i) {
      const Voxel at = corner();
      spend(65536);
      inner<5>(at, [&](const Voxel& below) {
        spend(8192);
        inner<4>(below, [&](const Voxel& leaf) {
          spend(Voxels::brick_size);
          openvdb::util::NodeMask<3> active;
          active.load(from_.stream());
          leaves_.push_back(leaf);
        });
      });
    }
    for (const Voxel& leaf : leaves_) read_leaf(leaf);
    return voxels_.finish(placement, background_);
  }
  std::size_t used() const { return used_; }

 private:
  void spend(std::size_t voxels) {
    used_ += voxels;
    if (used_ <= limit_) return;
    throw Refused{
        fmt::format("has more than the {} voxels that the grids of a scene may still have", limit_),
        false, true};
  }

  static float finite(float v) {
    if (!std::isfinite(v)) refuse("holds a value that is no number, or infinite");
    return v;
  }

  /// Place of a root's entry.
  Voxel corner() {
    Voxel at;
    for (auto& v : at) {
      v = from_.get<std::int32_t>();
      if (v % 4096 != 0) damaged();
      if (std::abs(std::int64_t{v}) > Voxels::farthest_voxel) {
        refuse(fmt::format("has voxels beyond index {}", Voxels::farthest_voxel));
      }
    }
    return at;
  }

  void tile(const Voxel& at, int level, float value, bool active) {
    if (!active && value == background_) return;
    voxels_.tile(at, level, finite(value));
  }

  /// A node of (2^bits)^3 entries; `child` reads those that are nodes.
  template <unsigned bits, class Child>
  void inner(const Voxel& at, Child child) {
    using Mask = openvdb::util::NodeMask<bits>;
    constexpr int side = bits == 5 ? 128 : 8;
    Mask children, active;
    children.load(from_.stream());
    active.load(from_.stream());
    std::array<float, Mask::SIZE>& values = scratch<bits>();
    read_values(active, values);
    const auto place = [&](unsigned n) {
      const auto axis = [&](unsigned shift) {
        return static_cast<std::int32_t>(n >> shift & ((1U << bits) - 1)) * side;
      };
      return Voxel{at[0] + axis(2 * bits), at[1] + axis(bits), at[2] + axis(0)};
    };
    for (unsigned n = 0; n < Mask::SIZE; ++n) {
      if (!children.isOn(n)) tile(place(n), bits == 5 ? 1 : 0, values[n], active.isOn(n));
    }
    for (unsigned n = 0; n < Mask::SIZE; ++n) {
      if (children.isOn(n)) child(place(n));
    }
  }
  /// One for each level, since a node's values are done with before those below it are read.
  template <unsigned bits>
  auto& scratch() {
    if constexpr (bits == 5)
      return *upper_;
    else
      return *lower_;
  }

  void read_leaf(const Voxel& at) {
    openvdb::util::NodeMask<3> active;
    active.load(from_.stream());
    std::array<float, Voxels::brick_size> values;
    read_values(active, values);
    for (unsigned n = 0; n < values.size(); ++n) {
      if (!active.isOn(n) && values[n] == background_) {
        values[n] = Voxels::unset;
      } else {
        finite(values[n]);
      }
    }
    voxels_.brick(at, values);
  }

  /// The values of a node: those that are active, the others by one or two values and a mask.
  template <class Mask>
  void read_values(const Mask& active, std::span<float> values) {
    const auto layout = from_.get<std::int8_t>();
    float first = layout == io::NO_MASK_OR_INACTIVE_VALS ? background_ : -background_;
    float second = background_;
    if (layout == io::NO_MASK_AND_ONE_INACTIVE_VAL || layout == io::MASK_AND_ONE_INACTIVE_VAL ||
        layout == io::MASK_AND_TWO_INACTIVE_VALS) {
      first = from_.get<float>();
      if (layout == io::MASK_AND_TWO_INACTIVE_VALS) second = from_.get<float>();
    }
    Mask selection;
    if (layout == io::MASK_AND_NO_INACTIVE_VALS || layout == io::MASK_AND_ONE_INACTIVE_VAL ||
        layout == io::MASK_AND_TWO_INACTIVE_VALS) {
      selection.load(from_.stream());
    }
    const bool masked = (compression_ & io::COMPRESS_ACTIVE_MASK) != 0;
    const bool all = !masked || layout == io::NO_MASK_AND_ALL_VALS;
    read_numbers(all ? static_cast<std::uint32_t>(values.size()) : active.countOn());
    std::size_t next = 0;
    for (unsigned n = 0; n < values.size(); ++n) {
      values[n] = all || active.isOn(n) ? buffer_[next++] : selection.isOn(n) ? second : first;
    }
  }

  /// Into buffer_.
  void read_numbers(std::uint32_t count) {
    if (!half_) return read_chunk(reinterpret_cast<char*>(buffer_.data()), 4 * std::size_t{count});
    if (count == 0) return;  // not even its length stands there
    halves_.resize(count);
    read_chunk(reinterpret_cast<char*>(halves_.data()), 2 * std::size_t{count});
    std::copy(halves_.begin(), halves_.end(), buffer_.begin());
  }

  /// `bytes` as they are, or behind their packed length; a length of -bytes says that packing did
  /// not help.
  void read_chunk(char* to, std::size_t bytes) {
    auto& in = from_.stream();
    const auto size = static_cast<std::int64_t>(bytes);
    const bool packed = (compression_ & (io::COMPRESS_ZIP | io::COMPRESS_BLOSC)) != 0;
    const auto stored = packed ? from_.get<std::int64_t>() : -size;
    if (stored <= 0) {
      if (stored != -size) damaged();
      in.read(to, size);
      return;
    }
    if (stored > 2 * size + 1024) damaged();
    packed_.resize(static_cast<std::size_t>(stored));
    in.read(packed_.data(), stored);
    if (bytes > 0 && !unpack(to, bytes)) damaged();
  }

  bool unpack(char* to, std::size_t bytes) const {
    if ((compression_ & io::COMPRESS_BLOSC) != 0) {
      std::size_t whole = 0;
      return blosc_cbuffer_validate(packed_.data(), packed_.size(), &whole) == 0 &&
             whole == bytes &&
             blosc_decompress_ctx(packed_.data(), to, bytes, 1) == static_cast<int>(bytes);
    }
    uLongf whole = bytes;
    return uncompress(reinterpret_cast<Bytef*>(to), &whole,
                      reinterpret_cast<const Bytef*>(packed_.data()), packed_.size()) == Z_OK &&
           whole == bytes;
  }

  Source& from_;
  bool half_;
  std::size_t limit_, used_ = 0;
  float background_ = 0;
  std::uint32_t compression_;
  std::vector<float> buffer_;
  std::vector<openvdb::math::half> halves_;
  std::vector<char> packed_;
  std::unique_ptr<std::array<float, 32768>> upper_ = std::make_unique<std::array<float, 32768>>();
  std::unique_ptr<std::array<float, 4096>> lower_ = std::make_unique<std::array<float, 4096>>();
  std::vector<Voxel> leaves_;
  Voxels::Builder voxels_;
};

/// What stands before the tree of a grid.
struct Head {
  std::uint32_t compression;
  Voxels::Placement placement;
};
Head read_head(Source& from, const Entry& entry) {
  from.seek(entry.start);
  const auto compression = from.get<std::uint32_t>();
  from.skip_metadata();
  return {compression, read_placement(from)};
}

Voxels read_grid(Source& from, const std::string& grid, std::size_t& voxels_left) {
  const auto listing = read_listing(from, openvdb::OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION,
                                    openvdb::OPENVDB_FILE_VERSION);
  io::setVersion(from.stream(), {listing.library_major, listing.library_minor}, listing.format);
  const auto& entries = listing.grids;
  const Entry& chosen = choose(entries, grid);
  auto head = read_head(from, chosen);
  const auto placement = head.placement;
  const Entry* owner = &chosen;  // of the tree: an instance shares another grid's
  if (!chosen.parent.empty()) {
    const auto found = std::find_if(entries.begin(), entries.end(), [&](const Entry& one) {
      return one.unique == chosen.parent && one.parent.empty() && one.fits();
    });
    if (found == entries.end()) damaged();
    owner = &*found;
    head = read_head(from, *owner);
  }
  TreeReader reader(from, head.compression, owner->half(), voxels_left);
  auto voxels = reader.read(placement);
  if (voxels.empty()) {
    throw Refused{fmt::format("has no voxel in its grid \"{}\"", chosen.name().substr(0, 80)),
                  true};
  }
  voxels_left -= reader.used();
  return voxels;
}

}  // namespace

std::optional<Voxels> read_vdb(const std::filesystem::path& file, const std::string& name,
                               const std::string& grid, const std::string& where,
                               std::size_t& voxels_left, Findings& findings) {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
  Refused refused;
  try {
    Source from(file);
    return read_grid(from, grid, voxels_left);
  } catch (const Refused& why) {
    refused = why;
  } catch (const std::exception&) {
    // The stream at its end, or a codec or map that could make nothing of its bytes.
    refused = {"is damaged or cut short"};
  }
  const Problem problem{where + (refused.of_grid ? "/grid" : "/file"),
                        fmt::format("\"{}\" {}", name, refused.what)};
  (refused.limit ? findings.limits : findings.problems).push_back(problem);
  return std::nullopt;
}

}  // namespace hoodoo::scene
