#pragma once
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/message.hpp"
#include "server/job/job.hpp"

/// The body of a request to carry out a process: execute.yaml of OGC API - Processes 1.0.
namespace hoodoo::http {

inline constexpr std::size_t most_key = 255;           // characters of an Idempotency-Key
inline constexpr std::size_t most_parsed = 32u << 20;  // [bytes] of the values of a body

/// What inputs by reference may lead to: nothing but files of this server, so that nobody can make
/// it ask another one.
struct References {
  std::string base;                          // address of the service
  std::vector<std::filesystem::path> roots;  // "file:" and assets lie below one of these
  /// The folder of a finished bake by the id of its job or the name of its tileset.
  std::function<std::optional<std::filesystem::path>(std::string_view name)> tileset;
  /// The scene of a finished bake by the id of its job; of one who may read it, where it is to be
  /// `read`: the id opens tiles and documents, not the scene.
  std::function<std::optional<std::filesystem::path>(std::string_view id, bool read)> scene;
  /// Called before a scene is read from the disk: what a small request makes large.
  std::function<void()> before_reading;
};

/// One request to carry out a process.
struct Execution {
  job::Request request;  // its inputs checked, references resolved
  bool raw = false;      // the one output itself is the answer, not a document of all
};

/// Reads a request to carry out `process`, which must be one.
/// Errors: bad_input with JSON Pointers into the body, and limit.
Execution read_execution(std::string_view process, const Request& request,
                         const References& references);

}  // namespace hoodoo::http
