#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/hash.hpp"
#include "engine/tree/balls.hpp"

namespace hoodoo {
class FileWriter;
}

namespace hoodoo::tree {

/// Balls in a file, along a Z-order curve and cut into cells of 1,024 of them. In memory is the
/// index of the cells alone, a tenth of a byte per ball. May be used from any thread.
class BallFile {
 public:
  /// Errors: io, also where it is damaged.
  explicit BallFile(std::filesystem::path path);
  ~BallFile();
  BallFile(const BallFile&) = delete;
  BallFile& operator=(const BallFile&) = delete;

  std::size_t size() const { return size_; }
  /// That of the list, as Balls::digest has it.
  const Digest& digest() const { return digest_; }
  /// All of them, in no particular order. Errors: io.
  void for_each(const std::function<void(const Balls::Stored&)>& visit) const;
  /// Those whose radius is at least `least` and, times `stretch`, plus `margin` [m], may reach
  /// `box`: none that does is left out. In the order of the list. Errors: io.
  std::vector<Balls::Stored> near(const Box& box, double stretch, double margin,
                                  double least) const;

 private:
  friend class BallFileWriter;
  static constexpr std::size_t cell_size = 1024;
  struct Cell {
    Box centers;
    double radius = 0;  // the largest
  };
  struct Head {
    std::uint64_t magic, size;
    Digest digest;
  };
  static constexpr std::uint64_t magic = 0x31736c6c61626868;

  void read(std::uint64_t place, void* into, std::size_t bytes) const;
  std::vector<Balls::Stored> cell(std::size_t index) const;

  std::filesystem::path path_;
  int file_ = -1;
  std::size_t size_ = 0;
  Digest digest_;
  std::vector<Cell> cells_;
};

/// Makes such a file from balls in the order of their list: sorted in runs that fit the memory,
/// which are then merged.
class BallFileWriter {
 public:
  /// `memory` [bytes] is for the balls held at once. Errors of all members: io.
  BallFileWriter(std::filesystem::path path, std::size_t memory);
  ~BallFileWriter();
  void add(const Ball& ball);
  /// Puts the file into its place.
  void finish();

 private:
  struct Run;
  struct Order;
  void sort_runs();
  void merge();

  std::filesystem::path path_;
  std::size_t most_;  // balls of a run
  std::unique_ptr<FileWriter> list_, runs_;
  std::size_t size_ = 0;
  Box centers_;
  BallDigest digest_;
};

}  // namespace hoodoo::tree
