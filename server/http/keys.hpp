#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/hash.hpp"
#include "server/job/job.hpp"

/// Who may use the service: bearer keys (RFC 6750), of which only the SHA-256 is kept.
namespace hoodoo::http {

/// What a key may do. `admin` includes the others, on the jobs of all owners.
enum class Scope { read, submit, admin };

struct Key {
  std::string name;  // of its owner
  Digest digest;     // of its text
  std::vector<Scope> scopes;
  job::Quota quota{};

  bool may(Scope scope) const;
};

/// Keys in a JSON file: {"keys": [{"name", "sha256", "scopes": ["read", "submit", "admin"],
/// "most": {"jobs", "bytes", "tiles", "extent"}}]}; of "most" any member may be absent, and all.
class Keys {
 public:
  Keys() = default;  // none: everybody may do everything
  /// Errors: not_found, io; bad_input naming the pointer of what is wrong.
  static Keys read(const std::filesystem::path& file);

  bool empty() const { return keys_.empty(); }
  /// The key of an Authorization header; null where it is none of these. Takes as long for every
  /// text of one length: all keys are compared, each in constant time.
  const Key* find(std::string_view authorization) const;

  /// Puts a new key into the file, in the place of those of that name; gives its text, which is
  /// kept nowhere. Errors: as `read`, for a file that is there; bad_input, a name that is no plain
  /// one.
  static std::string add(const std::filesystem::path& file, const std::string& name,
                         const std::vector<Scope>& scopes, const job::Quota& quota = {});

 private:
  std::vector<Key> keys_;
};

/// The keys of a file, which is read again when it has changed: a key that was taken out of it is
/// refused, a new one taken, about a second later. A file that is damaged or gone changes nothing,
/// and is logged.
class KeyRing {
 public:
  KeyRing() = default;  // none: everybody may do everything
  /// Errors: as Keys::read.
  explicit KeyRing(const std::filesystem::path& file);

  bool empty() const { return state_ == nullptr; }
  /// As Keys::find. May be called from any thread.
  std::optional<Key> find(std::string_view authorization) const;

 private:
  struct State;
  static void look(State& state);

  std::shared_ptr<State> state_;
};

Scope scope_of(std::string_view name);  // Errors: bad_input
std::string_view name_of(Scope scope);

}  // namespace hoodoo::http
