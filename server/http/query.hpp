#pragma once
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "server/http/message.hpp"
#include "server/job/store.hpp"

/// What a request asks for beyond its path.
namespace hoodoo::http {

using Query = std::map<std::string, std::string, std::less<>>;

/// "a=1&b=x%20y" decoded; of a name that comes twice the values are joined by commas.
/// Errors: bad_input, for what is no such text.
Query parse_query(std::string_view text);

/// The parameters of a job list (OGC 18-062r2, 11.2) and `before`, which the link to its next page
/// has. Errors: bad_input with every parameter that is wrong, and one that is unknown.
job::Filter filter_of(const Query& query);
/// The query of the next page.
std::string next_page(Query query, std::uint64_t before);

/// RFC 3339, to the millisecond. None when it is no such time.
std::optional<job::Time> parse_time(std::string_view text);

/// Preferences of RFC 7240 that are understood.
struct Preferences {
  bool respond_async = false;
  int wait = 0;  // [s], at most `most_wait`
};
inline constexpr int most_wait = 60;  // [s]
Preferences preferences_of(const Request& request);

}  // namespace hoodoo::http
