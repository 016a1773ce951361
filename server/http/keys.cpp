#include "server/http/keys.hpp"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <sys/random.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "server/http/files.hpp"
#include "server/http/log.hpp"

namespace hoodoo::http {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view prefix = "hoodoo_";
constexpr std::size_t most_bytes = 1 << 20;
constexpr std::array<std::pair<Scope, std::string_view>, 3> scope_names{
    {{Scope::read, "read"}, {Scope::submit, "submit"}, {Scope::admin, "admin"}}};

/// Reads the entries of a file of keys.
class Reader {
 public:
  explicit Reader(const fs::path& file) : file_(file) {}

  std::vector<Key> keys(const json& document) const {
    if (!document.is_object() || document.size() != 1 || !document.contains("keys") ||
        !document["keys"].is_array()) {
      fail("", "must be {\"keys\": [...]}");
    }
    std::vector<Key> keys;
    std::set<std::string> names;
    for (std::size_t n = 0; n < document["keys"].size(); ++n) {
      keys.push_back(key(document["keys"][n], fmt::format("/keys/{}", n)));
      if (!names.insert(keys.back().name).second) {
        fail(fmt::format("/keys/{}/name", n), "is the name of another key, " + keys.back().name);
      }
    }
    return keys;
  }

 private:
  Key key(const json& entry, const std::string& at) const {
    static const std::set<std::string> members{"name", "sha256", "scopes", "most"};
    if (!entry.is_object()) fail(at, "must be an object");
    for (const auto& member : entry.items()) {
      if (!members.contains(member.key())) fail(at + "/" + member.key(), "is not known here");
    }
    Key key;
    key.name = text(entry, at, "name");
    if (!is_plain_name(key.name)) {
      fail(at + "/name", "must be of letters, digits, '.', '_' and '-', got " + key.name);
    }
    const auto digest = Digest::parse(text(entry, at, "sha256"));
    if (!digest) fail(at + "/sha256", "must be 64 hexadecimal digits");
    key.digest = *digest;
    const auto scopes = entry.find("scopes");
    if (scopes == entry.end() || !scopes->is_array() || scopes->empty()) {
      fail(at + "/scopes", "must be a list of read, submit, admin");
    }
    for (std::size_t n = 0; n < scopes->size(); ++n) {
      const auto& name = (*scopes)[n];
      try {
        key.scopes.push_back(scope_of(name.is_string() ? name.get<std::string>() : name.dump()));
      } catch (const Error& error) {
        fail(fmt::format("{}/scopes/{}", at, n), error.problems.front().what);
      }
    }
    if (entry.contains("most")) key.quota = quota(entry["most"], at + "/most");
    return key;
  }
  job::Quota quota(const json& most, const std::string& at) const {
    if (!most.is_object()) fail(at, "must be an object");
    job::Quota quota;
    for (const auto& item : most.items()) {
      const auto where = at + "/" + item.key();
      const auto& value = item.value();
      if (item.key() == "extent") {
        if (!value.is_number() || !(value.get<double>() > 0)) fail(where, "must be above 0 m");
        quota.bake.extent = value.get<double>();
        continue;
      }
      auto* number = item.key() == "jobs"    ? &quota.jobs
                     : item.key() == "bytes" ? &quota.bytes
                     : item.key() == "tiles" ? &quota.bake.tiles
                                             : nullptr;
      if (number == nullptr) fail(where, "is not known here");
      const bool at_least_one = value.is_number_unsigned() && value.get<std::uint64_t>() > 0;
      if (!at_least_one) fail(where, "must be a whole number, 1 or more");
      *number = value.get<std::uint64_t>();
    }
    return quota;
  }
  std::string text(const json& entry, const std::string& at, const char* member) const {
    const auto found = entry.find(member);
    if (found == entry.end() || !found->is_string()) fail(at + "/" + member, "must be a text");
    return found->get<std::string>();
  }
  [[noreturn]] void fail(const std::string& at, const std::string& what) const {
    throw Error(Fault::bad_input, file_.string() + (at.empty() ? "" : "#" + at), what);
  }

  const fs::path& file_;
};

std::vector<Key> read_keys(const fs::path& file) {
  const auto document = json::parse(read_file(file, most_bytes), nullptr, false);
  if (document.is_discarded()) throw Error(Fault::bad_input, file.string(), "is no JSON");
  return Reader(file).keys(document);
}

json to_json(const job::Quota& quota) {
  json most = json::object();
  if (quota.jobs) most["jobs"] = *quota.jobs;
  if (quota.bytes) most["bytes"] = *quota.bytes;
  if (quota.bake.tiles) most["tiles"] = *quota.bake.tiles;
  if (quota.bake.extent) most["extent"] = *quota.bake.extent;
  return most;
}

std::string new_text() {
  std::array<unsigned char, 32> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw Error(Fault::io, "", "the system gives no random bytes");
  }
  std::string text(prefix);
  for (const unsigned byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

}  // namespace

Scope scope_of(std::string_view name) {
  for (const auto& [scope, text] : scope_names) {
    if (text == name) return scope;
  }
  throw Error(Fault::bad_input, "scope",
              "must be one of read, submit, admin, got " + std::string(name));
}

std::string_view name_of(Scope scope) {
  return std::ranges::find(scope_names, scope, &std::pair<Scope, std::string_view>::first)->second;
}

bool Key::may(Scope scope) const {
  return std::ranges::any_of(scopes, [&](Scope s) { return s == scope || s == Scope::admin; });
}

Keys Keys::read(const fs::path& file) {
  Keys keys;
  keys.keys_ = read_keys(file);
  if (keys.keys_.empty()) throw Error(Fault::bad_input, file.string() + "#/keys", "holds no key");
  return keys;
}

const Key* Keys::find(std::string_view authorization) const {
  constexpr std::string_view scheme = "bearer ";
  const bool is_bearer =
      authorization.size() > scheme.size() &&
      std::ranges::equal(authorization.substr(0, scheme.size()), scheme, [](char a, char b) {
        return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b;
      });
  const auto digest = sha256(is_bearer ? authorization.substr(scheme.size()) : authorization);
  const Key* found = nullptr;
  for (const auto& key : keys_) {
    const bool same =
        CRYPTO_memcmp(key.digest.bytes.data(), digest.bytes.data(), digest.bytes.size()) == 0;
    found = same ? &key : found;
  }
  return is_bearer ? found : nullptr;
}

/// What tells one content of a file from another; null where there is none.
using Stamp = std::optional<std::array<std::int64_t, 4>>;
Stamp stamp_of(const fs::path& file) {
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0) return std::nullopt;
  return std::array<std::int64_t, 4>{static_cast<std::int64_t>(found.st_ino), found.st_size,
                                     found.st_mtim.tv_sec, found.st_mtim.tv_nsec};
}

struct KeyRing::State {
  fs::path file;
  std::mutex mutex;  // guards all below
  Stamp seen;
  std::chrono::steady_clock::time_point looked;
  std::shared_ptr<const Keys> keys;
};

KeyRing::KeyRing(const fs::path& file) : state_(std::make_shared<State>()) {
  state_->file = file;
  state_->seen = stamp_of(file);
  state_->looked = std::chrono::steady_clock::now();
  state_->keys = std::make_shared<const Keys>(Keys::read(file));
}

/// With the mutex held. What changes after the stamp was taken has another one at the next look.
void KeyRing::look(State& state) {
  constexpr std::chrono::milliseconds between{500};
  const auto now = std::chrono::steady_clock::now();
  if (now - state.looked < between) return;
  state.looked = now;
  const auto stamp = stamp_of(state.file);
  if (stamp == state.seen) return;
  state.seen = stamp;
  try {
    state.keys = std::make_shared<const Keys>(Keys::read(state.file));
  } catch (const Error& error) {
    log_fault(fmt::format("keys: {}; those of before are kept", error.what()), "");
  }
}

std::optional<Key> KeyRing::find(std::string_view authorization) const {
  if (!state_) return std::nullopt;
  std::shared_ptr<const Keys> keys;
  {
    const std::lock_guard guard(state_->mutex);
    look(*state_);
    keys = state_->keys;
  }
  const auto* key = keys->find(authorization);
  return key == nullptr ? std::nullopt : std::optional(*key);
}

std::string Keys::add(const fs::path& file, const std::string& name,
                      const std::vector<Scope>& scopes, const job::Quota& quota) {
  if (!is_plain_name(name)) {
    throw Error(Fault::bad_input, "name",
                "must be of letters, digits, '.', '_' and '-' and not start with '.', got " + name);
  }
  std::error_code error;
  auto keys = fs::exists(file, error) ? read_keys(file) : std::vector<Key>();
  std::erase_if(keys, [&](const Key& key) { return key.name == name; });
  const auto text = new_text();
  keys.push_back({name, sha256(text), scopes, quota});
  json entries = json::array();
  for (const auto& key : keys) {
    json names = json::array();
    for (const auto scope : key.scopes) names.push_back(name_of(scope));
    entries.push_back({{"name", key.name}, {"sha256", key.digest.hex()}, {"scopes", names}});
    const auto most = to_json(key.quota);
    if (!most.empty()) entries.back()["most"] = most;
  }
  write_file(file, json{{"keys", entries}}.dump(2) + "\n");
  ::chmod(file.c_str(), S_IRUSR | S_IWUSR);
  return text;
}

}  // namespace hoodoo::http
