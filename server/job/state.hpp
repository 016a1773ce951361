#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "server/job/delivery.hpp"
#include "server/job/job.hpp"

/// Jobs as text.
namespace hoodoo::job {

std::string name_of(Status status);
std::string name_of(Fault fault);
std::string name_of(Event event);
/// Errors: bad_input.
Status status_of(std::string_view name);
Fault fault_of(std::string_view name);
Event event_of(std::string_view name);

/// One line of what `hoodoo bake --progress json` tells.
/// {"tile": "L/X/Y", "box": [least x, y, z, greatest x, y, z]}, in metres of the scene's frame.
nlohmann::json to_json(const bake::FinishedTile& tile);
nlohmann::json to_json(const bake::Progress& progress);
/// Errors: bad_input.
bake::Progress progress_from(const nlohmann::json& value);

/// What of a job nobody looks for: its outcome but for the report, why it failed, who is told, how
/// large it may be.
std::string to_text(const Job& job);

/// Puts that back. A damaged text makes a failed job that says so, so that one bad row costs one
/// job.
void read_text(std::string_view text, Job& job);

}  // namespace hoodoo::job
