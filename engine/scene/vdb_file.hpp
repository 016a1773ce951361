#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

/// What stands before the trees of an OpenVDB file.
namespace hoodoo::scene::vdb {

/// What makes a file unfit, in words that follow its name.
struct Refused {
  std::string what;
  bool of_grid = false;  // the problem stands at "grid", not at "file"
  bool limit = false;
};
[[noreturn]] void refuse(std::string what);
[[noreturn]] void damaged();

/// A file as a stream of little-endian values that throws where it ends.
class Source {
 public:
  explicit Source(const std::filesystem::path& file);

  std::istream& stream() { return in_; }
  template <class T>
  T get() {
    T v{};
    in_.read(reinterpret_cast<char*>(&v), sizeof(T));
    return v;
  }
  /// A length and so many letters.
  std::string text();
  std::int64_t place() { return in_.tellg(); }
  void seek(std::int64_t place);
  void skip_metadata();

 private:
  std::ifstream in_;
  std::int64_t size_ = 0;
};

/// One grid of a file.
struct Entry {
  std::string unique;  // its name, with a number among namesakes
  std::string type;
  std::string parent;  // whose tree it shares; empty: it has its own
  std::int64_t start = 0;

  std::string name() const;
  /// Its numbers are stored in half precision.
  bool half() const;
  /// Single precision in a tree of the usual shape.
  bool fits() const;
  /// "vec3s" of "Tree_vec3s_5_4_3".
  std::string numbers() const;
};

struct Listing {
  std::uint32_t format, library_major, library_minor;
  std::vector<Entry> grids;
};

/// The grids of a file. Refuses what is no OpenVDB file, or of a format not in [oldest, newest].
Listing read_listing(Source& from, std::uint32_t oldest, std::uint32_t newest);

/// The grid called `name`, or the first that fits where it is empty; what is wrong names those
/// there are.
const Entry& choose(const std::vector<Entry>& grids, const std::string& name);

}  // namespace hoodoo::scene::vdb
