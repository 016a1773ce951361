#pragma once
#include <chrono>
#include <semaphore>

namespace hoodoo::http {

/// One turn of those that may go on at once.
class Turn {
 public:
  /// Waits for it.
  explicit Turn(std::counting_semaphore<>& all) : all_(all), mine_(true) { all_.acquire(); }
  /// Waits no longer than this: see whether there is one.
  Turn(std::counting_semaphore<>& all, std::chrono::milliseconds patience)
      : all_(all), mine_(all.try_acquire_for(patience)) {}
  ~Turn() {
    if (mine_) all_.release();
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  explicit operator bool() const { return mine_; }

 private:
  std::counting_semaphore<>& all_;
  const bool mine_;
};

}  // namespace hoodoo::http
