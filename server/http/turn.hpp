#pragma once
#include <semaphore>

namespace hoodoo::http {

/// One turn of those that may go on at once, waited for.
class Turn {
 public:
  explicit Turn(std::counting_semaphore<>& all) : all_(all) { all_.acquire(); }
  ~Turn() { all_.release(); }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  std::counting_semaphore<>& all_;
};

}  // namespace hoodoo::http
