#include "engine/tree/ball_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <queue>
#include <span>
#include <system_error>
#include <tuple>
#include <utility>

#include "engine/base/error.hpp"
#include "engine/base/file_writer.hpp"
#include "engine/tree/morton.hpp"

namespace hoodoo::tree {
namespace {

using Stored = Balls::Stored;

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw Error(Fault::io, path.string(),
              "cannot be read: " + std::generic_category().message(errno));
}

int open_to_read(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) fail(path);
  return file;
}

void read_at(int file, const std::filesystem::path& path, std::uint64_t place, void* into,
             std::size_t bytes) {
  auto* to = static_cast<char*>(into);
  while (bytes > 0) {
    const auto got = ::pread(file, to, bytes, static_cast<off_t>(place));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(path);
    if (got == 0) throw Error(Fault::io, path.string(), "is damaged: it ends too early");
    to += got;
    place += static_cast<std::uint64_t>(got);
    bytes -= static_cast<std::size_t>(got);
  }
}

/// Points of `centers` that are no farther than `reach` from `box` along any axis.
bool may_reach(const Box& centers, const Box& box, double reach) {
  for (int axis = 0; axis < 3; ++axis) {
    if (centers.min[axis] - box.max[axis] > reach || box.min[axis] - centers.max[axis] > reach) {
      return false;
    }
  }
  return true;
}

}  // namespace

BallFile::BallFile(std::filesystem::path path)
    : path_(std::move(path)), file_(open_to_read(path_)) {
  try {
    Head head{};
    read(0, &head, sizeof head);
    size_ = head.size;
    digest_ = head.digest;
    const std::size_t cells = (size_ + cell_size - 1) / cell_size;
    const auto bytes = sizeof head + size_ * sizeof(Stored) + cells * sizeof(Cell);
    if (head.magic != magic || std::filesystem::file_size(path_) != bytes) {
      throw Error(Fault::io, path_.string(), "is damaged; delete it to make it anew");
    }
    cells_.resize(cells);
    read(sizeof head + size_ * sizeof(Stored), cells_.data(), cells * sizeof(Cell));
  } catch (...) {
    ::close(file_);
    throw;
  }
}
BallFile::~BallFile() { ::close(file_); }

void BallFile::read(std::uint64_t place, void* into, std::size_t bytes) const {
  read_at(file_, path_, place, into, bytes);
}

std::vector<Stored> BallFile::cell(std::size_t index) const {
  std::vector<Stored> balls(std::min(cell_size, size_ - index * cell_size));
  read(sizeof(Head) + index * cell_size * sizeof(Stored), balls.data(),
       balls.size() * sizeof(Stored));
  return balls;
}

void BallFile::for_each(const std::function<void(const Stored&)>& visit) const {
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    for (const auto& ball : cell(i)) visit(ball);
  }
}

std::vector<Stored> BallFile::near(const Box& box, double stretch, double margin,
                                   double least) const {
  std::vector<Stored> found;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const auto& [centers, radius] = cells_[i];
    if (radius < least || !may_reach(centers, box, stretch * radius + margin)) continue;
    for (const auto& b : cell(i)) {
      const Vec3 center{b.x, b.y, b.z};
      if (b.radius >= least && may_reach({center, center}, box, stretch * b.radius + margin)) {
        found.push_back(b);
      }
    }
  }
  std::ranges::sort(found, {}, &Stored::place);
  return found;
}

/// One ball after another of a sorted run, some of them in memory.
struct BallFileWriter::Run {
  std::size_t next, end;  // in the file of runs
  std::size_t most;       // balls held
  std::vector<Stored> held{};
  std::size_t at = 0;

  bool fill(int file, const std::filesystem::path& path) {
    if (at < held.size()) return true;
    held.resize(std::min(most, end - next));
    if (held.empty()) return false;
    read_at(file, path, next * sizeof(Stored), held.data(), held.size() * sizeof(Stored));
    next += held.size();
    at = 0;
    return true;
  }
};

struct BallFileWriter::Order {
  MortonCurve curve;
  std::tuple<std::uint64_t, std::uint32_t> operator()(const Stored& b) const {
    return {curve.at({b.x, b.y, b.z}), b.place};
  }
};

BallFileWriter::BallFileWriter(std::filesystem::path path, std::size_t memory)
    : path_(std::move(path)),
      most_(std::max(BallFile::cell_size, memory / 2 / sizeof(Stored))),
      list_(std::make_unique<FileWriter>(path_.string() + ".list")),
      runs_(std::make_unique<FileWriter>(path_.string() + ".runs")) {}
BallFileWriter::~BallFileWriter() = default;

void BallFileWriter::add(const Ball& b) {
  digest_.add(b);
  centers_.add(b.center);
  list_->put(Stored{b.center.x, b.center.y, b.center.z, b.radius, b.energy,
                    static_cast<std::uint32_t>(size_++)});
}

void BallFileWriter::finish() {
  sort_runs();
  merge();
}

void BallFileWriter::sort_runs() {
  list_->seek(list_->position());  // so that all of it can be read
  const auto& path = list_->temporary();
  const int file = open_to_read(path);
  const Order order{MortonCurve(centers_)};
  std::vector<Stored> run;
  for (std::size_t from = 0; from < size_; from += run.size()) {
    run.resize(std::min(most_, size_ - from));
    try {
      read_at(file, path, from * sizeof(Stored), run.data(), run.size() * sizeof(Stored));
    } catch (...) {
      ::close(file);
      throw;
    }
    std::ranges::sort(run, {}, order);
    runs_->write(std::as_bytes(std::span(run)));
  }
  ::close(file);
  list_.reset();
}

void BallFileWriter::merge() {
  runs_->seek(runs_->position());
  const auto& path = runs_->temporary();
  const std::size_t count = (size_ + most_ - 1) / most_;
  std::vector<Run> runs;
  for (std::size_t i = 0; i < count; ++i) {
    runs.push_back(
        {i * most_, std::min(size_, (i + 1) * most_), std::max<std::size_t>(64, most_ / count)});
  }
  const std::unique_ptr<const int, void (*)(const int*)> file(new int(open_to_read(path)),
                                                              [](const int* f) {
                                                                ::close(*f);
                                                                delete f;
                                                              });
  const Order order{MortonCurve(centers_)};
  using Next = std::pair<std::tuple<std::uint64_t, std::uint32_t>, Run*>;
  std::priority_queue<Next, std::vector<Next>, std::greater<>> queue;
  const auto push = [&](Run& run) {
    if (run.fill(*file, path)) queue.push({order(run.held[run.at]), &run});
  };
  for (auto& run : runs) push(run);
  FileWriter out(path_);
  out.put(BallFile::Head{BallFile::magic, size_, digest_.finish()});
  std::vector<BallFile::Cell> cells;
  for (std::size_t i = 0; !queue.empty(); ++i) {
    Run& run = *queue.top().second;
    queue.pop();
    const Stored& b = run.held[run.at++];
    if (i % BallFile::cell_size == 0) cells.emplace_back();
    cells.back().centers.add(Vec3{b.x, b.y, b.z});
    cells.back().radius = std::max(cells.back().radius, b.radius);
    out.put(b);
    push(run);
  }
  out.write(std::as_bytes(std::span(cells)));
  out.commit();
  runs_.reset();
}

}  // namespace hoodoo::tree
