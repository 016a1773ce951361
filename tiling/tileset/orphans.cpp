#include "tiling/tileset/orphans.hpp"

#include <algorithm>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/base/lock.hpp"

namespace hoodoo::tileset {

namespace fs = std::filesystem;

std::vector<fs::path> orphans(const fs::path& folder,
                              const std::function<bool(const fs::path&)>& is_named, bool complete) {
  const bool in_work = !complete || FileLock::is_held(folder / ".hoodoo" / "use.lock");
  const auto is_work = [&](const fs::path& file) {
    const auto top = *file.begin();
    return in_work && (is_leftover(file) || top == "tiles" || top == "subtrees");
  };
  std::vector<fs::path> found;
  std::error_code error;
  fs::recursive_directory_iterator at(folder, error), end;
  for (; !error && at != end; at.increment(error)) {
    const fs::path file = at->path().lexically_relative(folder);
    if (file == ".hoodoo") {
      at.disable_recursion_pending();
    } else if (at->is_regular_file(error) && !is_named(file) && !is_work(file)) {
      found.push_back(file);
    }
  }
  if (error) throw Error(Fault::io, folder.string(), error.message());
  std::ranges::sort(found);
  return found;
}

}  // namespace hoodoo::tileset
