#pragma once
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace hoodoo::hydrology {

/// Sets of numbers, joined pair by pair; the lowest of a set names it.
class Sets {
 public:
  explicit Sets(std::uint32_t count = 0) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }
  std::size_t size() const { return parent_.size(); }
  /// A set of the next number.
  std::uint32_t add() {
    parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
    return parent_.back();
  }
  std::uint32_t of(std::uint32_t n) {
    while (parent_[n] != n) n = parent_[n] = parent_[parent_[n]];
    return n;
  }
  /// By their names.
  void join(std::uint32_t low, std::uint32_t high) { parent_[high] = low; }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace hoodoo::hydrology
