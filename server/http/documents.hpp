#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "server/job/job.hpp"

/// The JSON documents of the service, in the words of OGC API - Processes 1.0 (OGC 18-062r2).
/// `base` is the address that every href starts with, without a slash at its end.
namespace hoodoo::http {

nlohmann::json landing_page(const std::string& base);

/// Of the class callback only where there are `callbacks`.
nlohmann::json conformance(bool callbacks);

/// statusInfo of OGC API - Processes 1.0 with what the draft of 2.0 requires, and beyond it: phase,
/// tiles{done,total,reused,cached}, secondsLeft, triangles, bytes, and the errors of a failed job.
/// `problems` are those of the job that may be seen.
nlohmann::json status_info(const job::Job& job, const std::vector<Problem>& problems,
                           const std::string& base);
/// `self` is the query of this page, `next` that of the one after it, empty when there is none.
nlohmann::json job_list(const std::vector<nlohmann::json>& jobs, const std::string& self,
                        const std::string& next, const std::string& base);

/// {"tilesets": [{"name", "href", "viewer"}]}: finished ones.
nlohmann::json tileset_list(const std::vector<std::string>& names, const std::string& base);

/// The outputs of a job that were asked for, by reference: {name: {"href", "type"}}. Where a
/// process gives files only when they are asked for, `files` says which there are. Of echo the
/// value, from the job's report.
nlohmann::json results(const job::Job& job, const std::vector<std::string>& files,
                       const std::string& base);
/// Of a job with its report.
nlohmann::json report(const job::Job& job);
/// Names of the files that a job has made in its folder of results, beside a tileset.
std::vector<std::string> result_files(const job::Job& job, const std::filesystem::path& folder);

/// What a subscriber is told: the results of a job that was successful, else its statusInfo.
/// `hidden` are folders whose names nobody sees.
std::string announcement(const job::Job& job, const std::filesystem::path& folder,
                         const std::string& base, const std::vector<std::string>& hidden);

}  // namespace hoodoo::http
