#pragma once
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace hoodoo {

/// Why something could not be done, seen from whoever asked for it.
/// Exit codes are known to server/main.cpp alone, HTTP statuses to server/http alone.
enum class Fault { bad_input, not_found, limit, cancelled, io, internal };

/// One thing wrong, and where: a JSON Pointer into the request, or a file.
struct Problem {
  std::string where;
  std::string what;
};

/// The one exception type thrown on purpose. `problems` is never empty, and holds everything
/// found wrong, so that a request hears of all its problems in one reply.
class Error : public std::runtime_error {
 public:
  Error(Fault why, std::vector<Problem> found)
      : std::runtime_error(summary(found)), fault(why), problems(std::move(found)) {}
  Error(Fault why, std::string where, std::string what)
      : Error(why, {Problem{std::move(where), std::move(what)}}) {}

  Fault fault;
  std::vector<Problem> problems;

 private:
  static std::string summary(const std::vector<Problem>& found) {
    std::string text;
    for (const auto& problem : found) {
      if (!text.empty()) text += "; ";
      if (!problem.where.empty()) text += problem.where + ": ";
      text += problem.what;
    }
    return text;
  }
};

}  // namespace hoodoo
