#pragma once
#include <string>
#include <string_view>

#include "server/job/job.hpp"

/// The text of job.json: everything of a job but its id, which names the folder.
namespace hoodoo::job {

std::string to_text(const Job& job);

/// A damaged file gives a failed job that says so, so that one bad file costs one job.
/// A job that was running counts as accepted: it continues.
Job from_text(std::string id, std::string_view text);

}  // namespace hoodoo::job
