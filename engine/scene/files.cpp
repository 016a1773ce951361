#include "engine/scene/files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

namespace hoodoo::scene {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t longest_name = 4096;

/// `path` is `folder` or below it; both absolute, without links.
bool lies_below(const fs::path& path, const fs::path& folder) {
  const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  (void)rest;
  // The path of a folder may end in an empty element ("a/b/").
  return end == folder.end() || (end->empty() && std::next(end) == folder.end());
}

/// Links followed as far as the path exists. None when it cannot be followed.
std::optional<fs::path> resolved(const fs::path& path) {
  std::error_code error;
  auto real = fs::weakly_canonical(fs::absolute(path, error), error);
  if (error) return std::nullopt;
  return real;
}

bool allowed(const fs::path& real, const Sources& sources) {
  return sources.roots.empty() ||
         std::any_of(sources.roots.begin(), sources.roots.end(), [&](const fs::path& root) {
           const auto folder = resolved(root);
           return folder && lies_below(real, *folder);
         });
}

}  // namespace

std::vector<Problem> Findings::all() const {
  auto list = problems;
  list.insert(list.end(), missing.begin(), missing.end());
  list.insert(list.end(), limits.begin(), limits.end());
  return list;
}

void Findings::report() const {
  if (!any()) return;
  const auto fault = !problems.empty() ? Fault::bad_input
                     : missing.empty() ? Fault::limit
                     : limits.empty()  ? Fault::not_found
                                       : Fault::bad_input;
  throw Error(fault, all());
}

std::optional<fs::path> find_file(const std::string& name, const std::string& where,
                                  const Sources& sources, Findings& findings) {
  if (name.empty() || name.size() > longest_name || name.find('\0') != name.npos) {
    findings.problems.push_back({where, "must be a file name"});
    return std::nullopt;
  }
  std::vector<fs::path> folders = {sources.base};
  folders.insert(folders.end(), sources.roots.begin(), sources.roots.end());
  bool outside = false;
  for (const auto& folder : folders) {
    auto real = resolved(folder / name);
    if (!real && sources.roots.empty()) continue;
    if (!real || !allowed(*real, sources)) {
      outside = true;
      continue;
    }
    std::error_code error;
    const auto status = fs::status(*real, error);
    if (!fs::exists(status)) continue;
    if (fs::is_regular_file(status)) return real;
    findings.problems.push_back({where, fmt::format("\"{}\" is not a regular file", name)});
    return std::nullopt;
  }
  if (outside) {
    findings.problems.push_back(
        {where, fmt::format("\"{}\" lies outside the folders that scenes may read", name)});
  } else {
    findings.missing.push_back({where, fmt::format("no file \"{}\"", name)});
  }
  return std::nullopt;
}

}  // namespace hoodoo::scene
