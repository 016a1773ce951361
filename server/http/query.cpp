#include "server/http/query.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>

#include "engine/base/error.hpp"
#include "server/http/tokens.hpp"
#include "server/job/state.hpp"

namespace hoodoo::http {
namespace {

constexpr std::uint64_t most_listed = 10'000;
constexpr std::int64_t most_seconds = std::int64_t{1} << 40;
constexpr std::size_t most_parameters = 32;

template <class Number>
std::optional<Number> number(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i] == '+' ? ' ' : text[i];
      continue;
    }
    unsigned char byte = 0;
    const auto digits = text.substr(i + 1, 2);
    const auto end = digits.data() + digits.size();
    const auto read = std::from_chars(digits.data(), end, byte, 16);
    if (digits.size() != 2 || read.ec != std::errc() || read.ptr != end || byte == 0) {
      throw Error(Fault::bad_input, "", "is not encoded as a URL is");
    }
    out += static_cast<char>(byte);
    i += 2;
  }
  return out;
}

/// An instant, or an interval "from/to" of which either may be ".." or empty.
bool read_interval(std::string_view text, job::Filter& filter) {
  const auto slash = text.find('/');
  const auto bound = [](std::string_view end, std::optional<job::Time>& into) {
    if (end.empty() || end == "..") return true;
    into = parse_time(end);
    return into.has_value();
  };
  if (slash == text.npos) {
    filter.from = filter.to = parse_time(text);
    return filter.from.has_value();
  }
  return bound(text.substr(0, slash), filter.from) && bound(text.substr(slash + 1), filter.to);
}

bool read_seconds(std::string_view text, std::optional<std::int64_t>& into) {
  const auto seconds = number<std::int64_t>(text);
  if (!seconds || *seconds < 0 || *seconds > most_seconds) return false;
  into = *seconds * 1000;
  return true;
}

/// What is wrong with one parameter; empty when nothing is.
std::string read_parameter(const std::string& name, const std::string& value, job::Filter& filter) {
  if (name == "limit") {
    const auto limit = number<std::uint64_t>(value);
    if (!limit || *limit == 0) return "must be an integer of 1 or more";
    filter.limit = std::min(*limit, most_listed);  // more may be asked for than is given
  } else if (name == "status") {
    try {
      split(value, ',', [&](auto one) { filter.statuses.push_back(job::status_of(one)); });
    } catch (const Error&) {
      return "must be of accepted, running, successful, failed, dismissed";
    }
  } else if (name == "processID") {
    split(value, ',', [&](auto one) { filter.processes.emplace_back(one); });
  } else if (name == "type") {
    bool processes = false;
    split(value, ',', [&](auto one) { processes = processes || one == "process"; });
    if (!processes) filter.processes = {""};  // jobs of no other type are here
  } else if (name == "datetime") {
    if (!read_interval(value, filter)) return "must be an RFC 3339 time, or two with \"/\" between";
  } else if (name == "minDuration") {
    if (!read_seconds(value, filter.shortest)) return "must be a number of whole seconds";
  } else if (name == "maxDuration") {
    if (!read_seconds(value, filter.longest)) return "must be a number of whole seconds";
  } else if (name == "before") {
    filter.before = number<std::uint64_t>(value);
    if (!filter.before || *filter.before > INT64_MAX) return "must be taken from a link";
  } else {
    return "is no parameter of a job list";
  }
  return {};
}

/// Of "20", with or without quotes; what is no number is none.
int seconds_of(std::string_view word) {
  if (word.size() > 1 && word.starts_with('"') && word.ends_with('"')) {
    word = word.substr(1, word.size() - 2);
  }
  if (word.empty() || word.find_first_not_of("0123456789") != word.npos) return 0;
  return std::min(number<int>(word).value_or(most_wait), most_wait);  // it may be any long
}

}  // namespace

Query parse_query(std::string_view text) {
  Query query;
  if (text.empty()) return query;
  split(text, '&', [&](std::string_view part) {
    if (part.empty()) return;
    const auto equals = part.find('=');
    auto name = decoded(part.substr(0, equals));
    auto value = equals == part.npos ? std::string() : decoded(part.substr(equals + 1));
    const auto [at, is_new] = query.emplace(std::move(name), value);
    if (!is_new) at->second += "," + value;
    if (query.size() > most_parameters) {
      throw Error(Fault::bad_input, "", "has too many parameters");
    }
  });
  return query;
}

job::Filter filter_of(const Query& query) {
  job::Filter filter;
  std::vector<Problem> problems;
  for (const auto& [name, value] : query) {
    auto wrong = read_parameter(name, value, filter);
    if (!wrong.empty()) problems.push_back({name, std::move(wrong)});
  }
  if (!problems.empty()) throw Error(Fault::bad_input, std::move(problems));
  return filter;
}

std::string next_page(Query query, std::uint64_t before) {
  query["before"] = std::to_string(before);
  std::string text;
  for (const auto& [name, value] : query) {
    text += (text.empty() ? "" : "&") + name + "=";
    for (const char c : value) {
      const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
                         (c >= 'A' && c <= 'Z') || c == '-' || c == '.' || c == '_' || c == ',';
      text += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  }
  return text;
}

std::optional<job::Time> parse_time(std::string_view text) {
  using namespace std::chrono;
  // 2026-01-31T23:59:59[.123](Z|+01:00)
  constexpr std::string_view shape = "dddd-dd-ddTdd:dd:dd";
  if (text.size() < shape.size() + 1) return std::nullopt;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    const bool digit = text[i] >= '0' && text[i] <= '9';
    if (shape[i] == 'd' ? !digit : text[i] != shape[i]) return std::nullopt;
  }
  const auto part = [&](std::size_t at, std::size_t length) {
    return number<int>(text.substr(at, length)).value_or(-1);
  };
  const year_month_day date{year(part(0, 4)), month(static_cast<unsigned>(part(5, 2))),
                            day(static_cast<unsigned>(part(8, 2)))};
  if (!date.ok() || part(11, 2) > 23 || part(14, 2) > 59 || part(17, 2) > 60) return std::nullopt;
  milliseconds time = hours(part(11, 2)) + minutes(part(14, 2)) + seconds(part(17, 2));
  text.remove_prefix(shape.size());
  if (text.starts_with('.')) {
    const auto end = std::min(text.find_first_not_of("0123456789", 1), text.size());
    if (end == 1) return std::nullopt;
    auto digits = std::string(text.substr(1, std::min<std::size_t>(end - 1, 3)));
    digits.resize(3, '0');
    time += milliseconds(*number<int>(digits));
    text.remove_prefix(end);
  }
  if (text == "Z" || text == "z") return sys_days(date) + time;
  if (text.size() != 6 || (text[0] != '+' && text[0] != '-') || text[3] != ':') return std::nullopt;
  const auto hour = number<unsigned>(text.substr(1, 2)), minute = number<unsigned>(text.substr(4));
  if (!hour || !minute || *hour > 23 || *minute > 59) return std::nullopt;
  const milliseconds offset = hours(*hour) + minutes(*minute);
  return sys_days(date) + time + (text[0] == '+' ? -offset : offset);
}

Preferences preferences_of(const Request& request) {
  Preferences preferences;
  split(request.header("prefer"), ',', [&](std::string_view part) {
    part = part.substr(0, part.find(';'));
    const auto equals = part.find('=');
    const auto name = trimmed(part.substr(0, equals));
    if (same_token(name, "respond-async")) preferences.respond_async = true;
    if (same_token(name, "wait") && equals != part.npos) {
      preferences.wait = seconds_of(trimmed(part.substr(equals + 1)));
    }
  });
  return preferences;
}

}  // namespace hoodoo::http
