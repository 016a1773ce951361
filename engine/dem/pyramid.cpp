#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <list>
#include <mutex>
#include <nlohmann/json.hpp>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/base/lock.hpp"
#include "engine/dem/chunks.hpp"
#include "engine/dem/dem.hpp"
#include "engine/dem/ingest.hpp"

namespace hoodoo::dem {
namespace {

/// Pixels [i0, i1) x [j0, j1) of a level.
struct Pixels {
  std::int64_t i0, j0, i1, j1;
};

// What a window over `area` holds: the stencils, and around them what their fills may come from.
// Beyond the grid there is nothing but what fills from its edge.
Pixels reached(const Pyramid::Level& level, const Box& area) {
  constexpr std::int64_t stencil = 2, spare = 1;
  constexpr std::int64_t margin = stencil + Window::fill_radius + spare;
  const auto pixel = [](double v, double origin, double size, std::int64_t most) {
    const double u = std::floor((v - origin) / size);
    const auto end = static_cast<double>(most + 2 * margin);
    return static_cast<std::int64_t>(std::clamp(u, -static_cast<double>(2 * margin), end));
  };
  return {pixel(area.min.x, level.x0, level.dx, level.width) - margin,
          pixel(area.min.y, level.y0, level.dy, level.height) - margin,
          pixel(area.max.x, level.x0, level.dx, level.width) + margin + 1,
          pixel(area.max.y, level.y0, level.dy, level.height) + margin + 1};
}

template <class Visit>
void for_each_chunk(const LevelFacts& level, const Pixels& p, const Visit& visit) {
  const auto i1 = std::min(p.i1, level.grid.width), j1 = std::min(p.j1, level.grid.height);
  for (auto row = std::max<std::int64_t>(0, p.j0) / chunk_side; row * chunk_side < j1; ++row) {
    for (auto column = std::max<std::int64_t>(0, p.i0) / chunk_side; column * chunk_side < i1;
         ++column) {
      visit(column, row);
    }
  }
}

class StoredPyramid : public Pyramid {
 public:
  StoredPyramid(std::string name, std::filesystem::path folder, const Digest& digest,
                std::size_t memory)
      : name_(std::move(name)),
        folder_(std::move(folder)),
        digest_(digest),
        facts_(read_index(folder_, digest)),
        most_(std::max<std::size_t>(16, memory / 2 / chunk_bytes)) {
    for (std::size_t k = 0; k < facts_.size(); ++k) {
      levels_.push_back(facts_[k].grid);
      files_.emplace_back(level_file(folder_, k), ChunkFile::Mode::read);
    }
    const auto& grid = levels_[0];
    for (const auto& chunk : facts_[0].chunks) {
      if (!chunk.valid) continue;
      extent_.min.z = std::min(extent_.min.z, static_cast<double>(chunk.low));
      extent_.max.z = std::max(extent_.max.z, static_cast<double>(chunk.high));
    }
    if (extent_.min.z <= extent_.max.z) {
      extent_.min.x = grid.x0;
      extent_.min.y = grid.y0;
      extent_.max.x = grid.x0 + static_cast<double>(grid.width) * grid.dx;
      extent_.max.y = grid.y0 + static_cast<double>(grid.height) * grid.dy;
    }
  }

  const std::vector<Level>& levels() const override { return levels_; }
  const std::string& name() const override { return name_; }
  const Digest& digest() const override { return digest_; }
  Box extent() const override { return extent_; }

  std::vector<Digest> chunks(int level, const Box& area) const override {
    const auto& facts = facts_.at(static_cast<std::size_t>(level));
    std::vector<Digest> found;
    for_each_chunk(facts, reached(facts.grid, area), [&](std::int64_t column, std::int64_t row) {
      found.push_back(facts.chunks[facts.index(column, row)].digest);
    });
    return found;
  }

  std::optional<Interval> bounds(int level, const Box& area) const override {
    const auto& facts = facts_.at(static_cast<std::size_t>(level));
    std::optional<Interval> range;
    for_each_chunk(facts, reached(facts.grid, area), [&](std::int64_t column, std::int64_t row) {
      const auto& chunk = facts.chunks[facts.index(column, row)];
      if (!chunk.valid) return;
      const Interval own{static_cast<double>(chunk.low), static_cast<double>(chunk.high)};
      range = range ? hull(*range, own) : own;
    });
    if (!range) return std::nullopt;
    return widened(static_cast<float>(range->low), static_cast<float>(range->high));
  }

  Window window(int level, const Box& area) const override {
    const auto& facts = facts_.at(static_cast<std::size_t>(level));
    const auto& grid = facts.grid;
    const auto p = reached(grid, area);
    const auto width = p.i1 - p.i0, height = p.j1 - p.j0;
    if (width <= 0 || height <= 0) return {};
    if (width > (std::int64_t{1} << 30) / height) {
      throw Error(
          Fault::limit, folder_.string(),
          fmt::format("a window of {} x {} pixels of {} m is too large", width, height, grid.dx));
    }
    std::vector<float> samples(static_cast<std::size_t>(width * height),
                               std::numeric_limits<float>::quiet_NaN());
    for_each_chunk(facts, p, [&](std::int64_t column, std::int64_t row) {
      if (!facts.chunks[facts.index(column, row)].valid) return;
      const auto pixels = chunk(static_cast<std::size_t>(level), facts.index(column, row));
      const auto left = column * chunk_side, low = row * chunk_side;
      const auto i0 = std::max(p.i0, left), i1 = std::min(p.i1, left + chunk_side);
      const auto j1 = std::min(p.j1, low + chunk_side);
      for (auto j = std::max(p.j0, low); j < j1; ++j) {
        std::copy_n(pixels->data() + (j - low) * chunk_side + (i0 - left), i1 - i0,
                    samples.data() + (j - p.j0) * width + (i0 - p.i0));
      }
    });
    return Window(grid.x0, grid.y0, grid.dx, grid.dy, p.i0, p.j0, static_cast<int>(width),
                  static_cast<int>(height), std::move(samples));
  }

 private:
  using Chunk = std::shared_ptr<const std::vector<float>>;
  struct Kept {
    std::uint64_t key;
    Chunk pixels;
  };

  // From memory, or from disk and checked there against its digest. The last used are in front.
  Chunk chunk(std::size_t level, std::size_t index) const {
    const auto key = static_cast<std::uint64_t>(index) << 6 | level;
    {
      const std::lock_guard lock(mutex_);
      if (const auto found = where_.find(key); found != where_.end()) {
        recent_.splice(recent_.begin(), recent_, found->second);
        return recent_.front().pixels;
      }
    }
    auto pixels = std::make_shared<std::vector<float>>(chunk_pixels);
    files_[level].read(index, *pixels);
    if (sha256(std::as_bytes(std::span(*pixels))) != facts_[level].chunks[index].digest) {
      refuse_damaged(level, index);
    }
    const std::lock_guard lock(mutex_);
    if (where_.contains(key)) return pixels;
    recent_.push_front({key, pixels});
    where_[key] = recent_.begin();
    if (recent_.size() > most_) {
      where_.erase(recent_.back().key);
      recent_.pop_back();
    }
    return pixels;
  }

  /// A pyramid without its index is made anew by the next who asks for it.
  [[noreturn]] void refuse_damaged(std::size_t level, std::size_t index) const {
    std::error_code failure;
    std::filesystem::remove(index_file(folder_), failure);
    throw Error(Fault::io, level_file(folder_, level).string(),
                fmt::format("chunk {} is damaged; {}", index,
                            failure ? "delete the folder to make it anew"
                                    : "the next run makes the elevations anew"));
  }

  std::string name_;
  std::filesystem::path folder_;
  Digest digest_;
  std::vector<LevelFacts> facts_;
  std::vector<Level> levels_;
  std::vector<ChunkFile> files_;
  Box extent_;
  std::size_t most_;
  mutable std::mutex mutex_;
  mutable std::list<Kept> recent_;
  mutable std::unordered_map<std::uint64_t, std::list<Kept>::iterator> where_;
};

/// A folder that vanishes with what is in it unless it is moved into its place.
class Unfinished {
 public:
  explicit Unfinished(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::filesystem::remove_all(folder_, failure_);  // of a process that was killed
    if (!std::filesystem::create_directory(folder_, failure_)) fail("cannot be made");
  }
  ~Unfinished() { std::filesystem::remove_all(folder_, failure_); }
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  /// A damaged one may be in its place.
  void finish(const std::filesystem::path& place) {
    std::filesystem::remove_all(place, failure_);
    std::filesystem::rename(folder_, place, failure_);
    if (failure_) fail("cannot be renamed into place");
  }

 private:
  [[noreturn]] void fail(const char* what) const {
    throw Error(Fault::io, folder_.string(), std::string(what) + ": " + failure_.message());
  }
  std::filesystem::path folder_;
  std::error_code failure_;
};

Digest name_of(const Digest& content, const Frame& frame, double pixel,
               std::optional<double> fill) {
  const nlohmann::json all = {{"format", 1},
                              {"content", content.hex()},
                              {"crs", frame.crs},
                              {"unit", frame.unit},
                              {"origin", {frame.origin_x, frame.origin_y}},
                              {"pixel", pixel},
                              {"fill", fill ? nlohmann::json(*fill) : nlohmann::json(nullptr)}};
  return sha256(all.dump());
}

/// A finished pyramid; nothing where there is none, or one that is damaged.
template <class Open>
std::shared_ptr<const Pyramid> opened(const std::filesystem::path& place, const Open& open) {
  std::error_code failure;
  if (!std::filesystem::exists(index_file(place), failure)) return nullptr;
  try {
    return open();
  } catch (const Error&) {
    return nullptr;
  }
}

std::shared_ptr<const Pyramid> find_or_make(const std::filesystem::path& raster, const Frame& frame,
                                            double pixel, std::optional<double> fill,
                                            const std::filesystem::path& folder,
                                            const IngestSettings& settings) {
  const auto before = file_state(raster);
  const auto made = recipe(Raster::open(raster)->info(), frame, pixel, fill);
  const auto digest =
      name_of(digest_of_file(raster, settings.stop), frame, made.copied ? 0 : pixel, fill);
  const auto place = folder / digest.hex();
  const auto open = [&] {
    return std::make_shared<StoredPyramid>(raster.filename().string(), place, digest,
                                           settings.memory);
  };
  if (auto found = opened(place, open)) return found;
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure) throw Error(Fault::io, folder.string(), "cannot be made: " + failure.message());
  // One, of all threads and processes, makes a certain pyramid.
  const FileLock lock(place.string() + ".lock", FileLock::Kind::exclusive, settings.stop);
  // Another may have made it while this one waited.
  if (auto found = opened(place, open)) return found;
  Unfinished unfinished(place.string() + ".part");
  make_pyramid(made, digest, unfinished.folder(), settings);
  expect_unchanged(raster, before);
  unfinished.finish(place);
  return open();
}

}  // namespace

void expect_unchanged(const std::filesystem::path& raster, const std::optional<FileState>& before) {
  if (file_state(raster) == before) return;
  throw Error(Fault::io, raster.string(), "changed while it was read");
}

int Pyramid::level_for(double spacing) const {
  const auto& all = levels();
  int found = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (std::max(all[k].dx, all[k].dy) <= spacing) found = static_cast<int>(k);
  }
  return found;
}

std::shared_ptr<const Pyramid> Pyramid::ingest(const std::filesystem::path& raster,
                                               const Frame& frame, double pixel,
                                               std::optional<double> fill,
                                               const std::filesystem::path& folder,
                                               const IngestSettings& settings) {
  const auto before = file_state(raster);
  try {
    auto pyramid = find_or_make(raster, frame, pixel, fill, folder, settings);
    if (settings.progress) settings.progress(1);
    return pyramid;
  } catch (const Error& error) {
    // What the change did to the reading would only mislead.
    if (error.fault != Fault::cancelled) expect_unchanged(raster, before);
    throw;
  }
}

}  // namespace hoodoo::dem
