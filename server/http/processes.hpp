#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// What the service can do, in the words of OGC API - Processes 1.0 (OGC 18-062r2).
namespace hoodoo::http {

inline constexpr std::string_view echo_process = "echo";
inline constexpr std::string_view validate_process = "validate-scene";
inline constexpr double most_pause = 10;               // [s] of echo
inline constexpr std::size_t most_paused = 64u << 10;  // [bytes] of a body that echo waits with
inline constexpr std::size_t most_kept = 64u << 10;    // [bytes] of what a job echoes, as JSON

/// How a process may be carried out.
struct Control {
  bool async = false, sync = false;
};
/// None when there is no such process.
std::optional<Control> control_of(std::string_view process);

/// Names of the outputs of a process, which must be one.
std::vector<std::string> output_names(std::string_view process);

nlohmann::json process_list(const std::string& base);
/// The process must be one.
nlohmann::json process_description(std::string_view process, const std::string& base,
                                   const nlohmann::json& scene_schema);

}  // namespace hoodoo::http
