#include "engine/dem/ingest.hpp"

#include <fcntl.h>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>
#include <oneapi/tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

#include "engine/base/error.hpp"

namespace hoodoo::dem {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

void check_stop(const std::stop_token& stop, const std::filesystem::path& path) {
  if (stop.stop_requested())
    throw Error(Fault::cancelled, path.string(), "ingesting was cancelled");
}

/// Counts finished chunks for whoever watches.
class Progress {
 public:
  Progress(const IngestSettings& settings, std::int64_t chunks)
      : tell_(settings.progress), all_(static_cast<double>(chunks)) {}
  void add(std::int64_t chunks) {
    const auto done = done_ += chunks;
    if (tell_) tell_(std::min(1.0, static_cast<double>(done) / all_));
  }

 private:
  const std::function<void(double)>& tell_;
  double all_;
  std::atomic<std::int64_t> done_{0};
};

/// Objects that one thread uses at a time: as many as there are threads at work.
class ResamplerPool {
 public:
  ResamplerPool(const Recipe& recipe, std::size_t keep) : recipe_(recipe), keep_(keep) {}

  std::unique_ptr<Resampler> take() {
    {
      const std::lock_guard lock(mutex_);
      if (!idle_.empty()) {
        auto resampler = std::move(idle_.back());
        idle_.pop_back();
        return resampler;
      }
    }
    auto raster = Raster::open(recipe_.info.path);
    raster->keep(keep_);
    return std::make_unique<Resampler>(std::move(raster), recipe_);
  }
  void give(std::unique_ptr<Resampler> resampler) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(resampler));
  }

 private:
  const Recipe& recipe_;
  std::size_t keep_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Resampler>> idle_;
};

/// How level 0 is cut into tasks so that each block of the file is decoded about once and the
/// blocks in use fit the memory.
struct Schedule {
  int workers;
  std::size_t keep;  // bytes of decoded blocks per worker
  std::int64_t run;  // chunks per task, from west to east
  int rows;          // of pixels made across the run before the next rows are
};

Schedule schedule(const Recipe& recipe, const IngestSettings& settings) {
  const auto raster = Raster::open(recipe.info.path);
  const auto block = raster->block();
  const auto memory = std::max<std::size_t>(settings.memory, 16u << 20) / 2;
  const auto across = (recipe.grid.width + chunk_side - 1) / chunk_side;
  const bool striped = block.width == recipe.info.width;
  // Blocks touched by one row of work: `rows` of the raster with a margin for the stencil and for
  // rows that run askew to the frame's.
  const auto needed = [&](int rows) {
    const auto down = (rows + rows / 4 + 16) / block.height + 2;
    const auto wide = striped ? 1 : (chunk_side + 80) / block.width + 2;
    return static_cast<std::size_t>(down * wide) * block.bytes;
  };
  int rows = chunk_side;
  while (striped && rows > SourceMap::patch && needed(rows) > memory) rows /= 2;
  const auto workers = std::clamp<std::size_t>(
      memory / needed(rows), 1, static_cast<std::size_t>(std::max(1, settings.threads)));
  return {static_cast<int>(workers), memory / workers,
          striped ? across : std::min<std::int64_t>(across, 16), rows};
}

/// Makes the chunks [first, first + count) of one row of chunks.
void make_run(Resampler& resampler, LevelFacts& level, ChunkFile& file, std::int64_t first,
              std::int64_t count, std::int64_t row, int rows, const std::stop_token& stop,
              const std::filesystem::path& path) {
  std::vector<float> pixels(chunk_pixels);
  const auto part = static_cast<std::size_t>(rows) * chunk_side;
  for (int low = 0; low < chunk_side; low += rows) {
    for (auto column = first; column < first + count; ++column) {
      check_stop(stop, path);
      std::fill_n(pixels.begin(), part, nan);
      resampler.make(column * chunk_side, row * chunk_side + low, chunk_side, rows, pixels.data(),
                     chunk_side);
      const auto chunk = level.index(column, row);
      if (rows == chunk_side) {
        level.chunks[chunk] = describe_chunk(pixels);
        if (level.chunks[chunk].valid) file.write(chunk, 0, pixels);
      } else {
        file.write(chunk, static_cast<std::size_t>(low) * chunk_side,
                   std::span(pixels).first(part));
      }
    }
  }
  if (rows == chunk_side) return;
  for (auto column = first; column < first + count; ++column) {
    const auto chunk = level.index(column, row);
    file.read(chunk, pixels);
    level.chunks[chunk] = describe_chunk(pixels);
  }
}

template <class Task>
void in_parallel(int threads, std::int64_t tasks, const Task& task) {
  // More threads than processors are had only when asked for so.
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::int64_t>(0, tasks, 1),
        [&](const tbb::blocked_range<std::int64_t>& range) {
          for (auto k = range.begin(); k != range.end(); ++k) task(k);
        },
        tbb::simple_partitioner());
  });
}

void make_level_0(const Recipe& recipe, LevelFacts& level, ChunkFile& file,
                  const IngestSettings& settings, Progress& progress) {
  const auto plan = schedule(recipe, settings);
  ResamplerPool pool(recipe, plan.keep);
  const auto runs = (level.across() + plan.run - 1) / plan.run;
  in_parallel(plan.workers, runs * level.down(), [&](std::int64_t task) {
    const auto first = task % runs * plan.run;
    const auto count = std::min(plan.run, level.across() - first);
    auto resampler = pool.take();
    make_run(*resampler, level, file, first, count, task / runs, plan.rows, settings.stop,
             recipe.info.path);
    pool.give(std::move(resampler));
    progress.add(count);
  });
}

/// The mean of the valid ones of each 2 x 2 pixels of `fine`, 512 x 512.
void halve(const std::vector<float>& fine, std::vector<float>& coarse) {
  constexpr std::size_t side = 2 * std::size_t{chunk_side};
  for (std::size_t j = 0; j < chunk_side; ++j) {
    for (std::size_t i = 0; i < chunk_side; ++i) {
      const float* const from = fine.data() + 2 * j * side + 2 * i;
      double sum = 0;
      int count = 0;
      for (const float v : {from[0], from[1], from[side], from[side + 1]}) {
        if (std::isnan(v)) continue;
        sum += static_cast<double>(v);
        ++count;
      }
      coarse[j * chunk_side + i] = count ? static_cast<float>(sum / count) : nan;
    }
  }
}

void make_coarser(const LevelFacts& below, const ChunkFile& from, LevelFacts& level,
                  ChunkFile& file, const Recipe& recipe, const IngestSettings& settings,
                  Progress& progress) {
  const auto task = [&](std::int64_t index) {
    check_stop(settings.stop, recipe.info.path);
    const auto column = index % level.across(), row = index / level.across();
    std::vector<float> fine(4 * chunk_pixels, nan), pixels(chunk_pixels);
    for (int quarter = 0; quarter < 4; ++quarter) {
      const auto x = 2 * column + quarter % 2, y = 2 * row + quarter / 2;
      if (x >= below.across() || y >= below.down() || !below.chunks[below.index(x, y)].valid) {
        continue;
      }
      from.read(below.index(x, y), pixels);
      for (int j = 0; j < chunk_side; ++j) {
        std::copy_n(pixels.begin() + std::ptrdiff_t{j} * chunk_side, chunk_side,
                    fine.begin() + (std::ptrdiff_t{quarter / 2} * chunk_side + j) * 2 * chunk_side +
                        std::ptrdiff_t{quarter % 2} * chunk_side);
      }
    }
    halve(fine, pixels);
    auto& chunk = level.chunks[static_cast<std::size_t>(index)];
    chunk = describe_chunk(pixels);
    if (chunk.valid) file.write(static_cast<std::size_t>(index), 0, pixels);
    progress.add(1);
  };
  in_parallel(std::max(1, settings.threads), level.across() * level.down(), task);
}

std::vector<LevelFacts> all_levels(const Pyramid::Level& first) {
  std::vector<LevelFacts> levels;
  for (auto grid = first;;) {
    levels.push_back({grid, {}});
    auto& level = levels.back();
    level.chunks.resize(static_cast<std::size_t>(level.across() * level.down()));
    if (grid.width <= 2 && grid.height <= 2) return levels;
    grid.dx *= 2;
    grid.dy *= 2;
    grid.width = (grid.width + 1) / 2;
    grid.height = (grid.height + 1) / 2;
  }
}

}  // namespace

void make_pyramid(const Recipe& recipe, const Digest& digest, const std::filesystem::path& folder,
                  const IngestSettings& settings) {
  auto levels = all_levels(recipe.grid);
  std::int64_t chunks = 0;
  for (const auto& level : levels) chunks += static_cast<std::int64_t>(level.chunks.size());
  Progress progress(settings, chunks);

  ChunkFile below(level_file(folder, 0), ChunkFile::Mode::create);
  make_level_0(recipe, levels[0], below, settings, progress);
  below.sync();
  auto previous = std::make_unique<ChunkFile>(std::move(below));
  for (std::size_t k = 1; k < levels.size(); ++k) {
    auto file = std::make_unique<ChunkFile>(level_file(folder, k), ChunkFile::Mode::create);
    make_coarser(levels[k - 1], *previous, levels[k], *file, recipe, settings, progress);
    file->sync();
    previous = std::move(file);
  }
  write_index(folder, digest, levels);
}

Digest digest_of_file(const std::filesystem::path& path, const std::stop_token& stop) {
  struct Close {
    int fd;
    ~Close() { ::close(fd); }
  };
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) {
    throw Error(errno == ENOENT ? Fault::not_found : Fault::io, path.string(), "cannot be opened");
  }
  const Close close{fd};
  Sha256 hash;
  std::vector<std::byte> buffer(1 << 20);
  for (;;) {
    check_stop(stop, path);
    const auto got = ::read(fd, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Error(Fault::io, path.string(), "cannot be read");
    if (got == 0) return hash.finish();
    hash.add(std::span(buffer).first(static_cast<std::size_t>(got)));
  }
}

}  // namespace hoodoo::dem
