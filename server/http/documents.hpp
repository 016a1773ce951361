#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "server/job/job.hpp"

/// The JSON documents of the service, in the words of OGC API - Processes 1.0 (OGC 18-062r2).
/// `base` is the address that every href starts with, without a slash at its end.
namespace hoodoo::http {

inline constexpr const char* bake_process = "bake-terrain";

nlohmann::json landing_page(const std::string& base);

/// No conformance class is declared: the core asks for inputs by reference, which a bake does not
/// take.
nlohmann::json conformance();

nlohmann::json process_list(const std::string& base);
nlohmann::json process_description(const std::string& base, const nlohmann::json& scene_schema);

/// statusInfo, and beyond it: phase, tiles{done,total,reused}, triangles, bytes, complete,
/// warnings, and the errors of a failed job. `problems` are those of the job that may be seen.
nlohmann::json status_info(const job::Job& job, const std::vector<Problem>& problems,
                           const std::string& base);
nlohmann::json job_list(const std::vector<nlohmann::json>& jobs, const std::string& base);

/// {"tilesets": [{"name", "href", "viewer"}]}: finished ones.
nlohmann::json tileset_list(const std::vector<std::string>& names, const std::string& base);

/// Tileset, manifest and report by reference.
nlohmann::json results(const job::Job& job, const std::string& base);
nlohmann::json report(const job::Job& job);

}  // namespace hoodoo::http
