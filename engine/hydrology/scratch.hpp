#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace hoodoo::hydrology {

/// A nameless file for what does not fit in memory; it goes with its object, or with the process.
/// What was never written reads as zeros. Errors of all members: io, naming the folder.
class Scratch {
 public:
  explicit Scratch(std::filesystem::path folder);
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  /// Numbers of one type by their place in the file.
  template <class Value>
  void write(std::uint64_t first, std::span<const Value> values) {
    write_bytes(first * sizeof(Value), std::as_bytes(values));
  }
  template <class Value>
  void read(std::uint64_t first, std::span<Value> values) const {
    read_bytes(first * sizeof(Value), std::as_writable_bytes(values));
  }

 private:
  void write_bytes(std::uint64_t at, std::span<const std::byte> bytes);
  void read_bytes(std::uint64_t at, std::span<std::byte> bytes) const;

  std::filesystem::path folder_;
  int file_ = -1;
};

}  // namespace hoodoo::hydrology
