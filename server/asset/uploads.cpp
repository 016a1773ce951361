#include "server/asset/uploads.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/base/json.hpp"

namespace hoodoo::asset {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using std::chrono::seconds;

constexpr std::uintmax_t most_state = 64u << 10;  // [bytes]
constexpr seconds longest_wait{60};               // between two looks for what is over

Time now() { return std::chrono::floor<seconds>(std::chrono::system_clock::now()); }

/// When a file was written to last.
Time time_of(const fs::path& file) {
  const auto state = file_state(file);
  return Time(seconds(state ? state->seconds : 0));
}

json to_json(const Upload& upload) {
  json state{{"length", upload.length}, {"owner", upload.owner}};
  if (upload.wanted) state["wanted"] = upload.wanted->hex();
  if (upload.made) state["made"] = upload.made->hex();
  return state;
}

Upload from_json(const json& state, std::string id) {
  Upload upload;
  upload.id = std::move(id);
  state.at("length").get_to(upload.length);
  state.at("owner").get_to(upload.owner);
  const auto digest = [&state](const char* name) -> std::optional<Digest> {
    if (!state.contains(name)) return std::nullopt;
    return Digest::parse(state[name].get<std::string>()).value();
  };
  upload.wanted = digest("wanted");
  upload.made = digest("made");
  return upload;
}

}  // namespace

struct Uploads::Record {
  Upload upload;
  RunningHash hash;
  Space space;
  bool taken = false;
};

Uploads::Uploads(Assets& assets, seconds patience)
    : assets_(assets), folder_(assets.under_way()), patience_(patience) {
  open();
  collector_ = std::jthread([this](const std::stop_token& stop) {
    const auto wait = std::clamp(patience_ / 2, seconds(1), longest_wait);
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      waiting_.wait_for(lock, stop, wait, [] { return false; });
      collect();
    }
  });
}

Uploads::~Uploads() = default;

fs::path Uploads::data_of(std::string_view id) const {
  return folder_ / (std::string(id) + ".data");
}
fs::path Uploads::state_of(std::string_view id) const {
  return folder_ / (std::string(id) + ".json");
}

/// Takes up what an earlier server left.
void Uploads::open() {
  std::vector<fs::path> states, contents;
  for (const auto& item : fs::directory_iterator(folder_)) {
    const auto ending = item.path().extension();
    if (ending == ".json") states.push_back(item.path());
    if (ending == ".data") contents.push_back(item.path());
  }
  for (const auto& state : states) open_one(state.stem().string());
  for (const auto& content : contents) {
    const auto found = records_.find(content.stem().string());
    if (found == records_.end() || found->second->upload.made) fs::remove(content);
  }
  forget_oldest();
}

/// One that is damaged, or for which there is no space any more, is gone.
void Uploads::open_one(const std::string& id) {
  try {
    auto record = std::make_shared<Record>();
    auto& upload = record->upload =
        from_json(parse_json(read_file(state_of(id), most_state), id), id);
    std::error_code error;
    // Killed after it had become an asset, before it could say so.
    if (!upload.made && upload.wanted && !fs::exists(data_of(id)) &&
        assets_.holds(*upload.wanted)) {
      upload.made = upload.wanted;
    }
    upload.offset = upload.made ? upload.length : fs::file_size(data_of(id), error);
    const auto changed = upload.made ? time_of(state_of(id)) : time_of(data_of(id));
    upload.expires = changed + patience_;
    if (error || upload.offset > upload.length || upload.expires <= now()) return forget(id);
    if (!upload.made) record->space = assets_.reserve(upload.length);
    records_.emplace(id, std::move(record));
  } catch (const std::exception&) {
    forget(id);
  }
}

void Uploads::forget(const std::string& id) const {
  std::error_code ignored;
  fs::remove(state_of(id), ignored);
  fs::remove(data_of(id), ignored);
}

void Uploads::save(const Upload& upload) const {
  write_file(state_of(upload.id), to_json(upload).dump());
}

/// With the mutex held.
void Uploads::collect() {
  const auto time = now();
  std::erase_if(records_, [&](const auto& entry) {
    const auto& record = *entry.second;
    if (record.taken || record.upload.expires > time) return false;
    forget(entry.first);
    return true;
  });
}

/// Of the finished ones, those beyond `most`. With the mutex held.
void Uploads::forget_oldest() {
  std::vector<std::pair<Time, std::string>> finished;
  std::size_t held = 0;
  for (const auto& [id, record] : records_) {
    if (!record->upload.made) continue;
    if (record->taken) {
      ++held;
    } else {
      finished.emplace_back(record->upload.expires, id);
    }
  }
  if (finished.size() + held <= most) return;
  std::ranges::sort(finished);
  finished.resize(std::min(finished.size(), finished.size() + held - most));
  for (const auto& [time, id] : finished) {
    forget(id);
    records_.erase(id);
  }
}

/// With the mutex held.
std::optional<Uploads::Full> Uploads::full(std::string_view owner) const {
  std::size_t all = 0, own = 0;
  for (const auto& [id, record] : records_) {
    if (record->upload.made) continue;
    ++all;
    if (record->upload.owner == owner) ++own;
  }
  if (!owner.empty() && own >= most_of_owner) return Full::owner;
  if (all >= most) return Full::all;
  return std::nullopt;
}

std::variant<Upload, Uploads::Full> Uploads::create(std::uint64_t length,
                                                    const std::optional<Digest>& wanted,
                                                    const std::string& owner) {
  auto record = std::make_shared<Record>();
  record->space = assets_.reserve(length);
  auto& upload = record->upload;
  upload = {random_name(), owner, length, 0, wanted, {}, now() + patience_};
  const std::lock_guard guard(mutex_);
  if (const auto why = full(owner)) return *why;
  try {
    const Incoming made(data_of(upload.id), record->hash);
    save(upload);
  } catch (...) {
    forget(upload.id);
    throw;
  }
  records_.emplace(upload.id, record);
  return upload;
}

std::optional<Upload> Uploads::find(std::string_view id) const {
  const std::lock_guard guard(mutex_);
  const auto found = records_.find(id);
  if (found == records_.end()) return std::nullopt;
  auto upload = found->second->upload;
  if (upload.expires <= now() && !found->second->taken) return std::nullopt;
  // Its content leaves when it is whole.
  std::error_code gone;
  const auto size = fs::file_size(data_of(id), gone);
  upload.offset = gone ? upload.length : size;
  return upload;
}

std::uint64_t Uploads::under_way(std::string_view owner) const {
  const std::lock_guard guard(mutex_);
  std::uint64_t bytes = 0;
  for (const auto& [id, record] : records_) {
    const auto& upload = record->upload;
    if (upload.owner == owner && !upload.made) bytes += upload.length;
  }
  return bytes;
}

std::unique_ptr<Uploads::Turn> Uploads::take(std::string_view id) {
  std::shared_ptr<Record> record;
  {
    const std::lock_guard guard(mutex_);
    const auto found = records_.find(id);
    if (found == records_.end() || found->second->taken || found->second->upload.made) {
      return nullptr;
    }
    record = found->second;
    record->taken = true;
  }
  try {
    return std::make_unique<Turn>(*this, record);
  } catch (...) {
    const std::lock_guard guard(mutex_);
    record->taken = false;
    throw;
  }
}

bool Uploads::remove(std::string_view id) {
  const std::lock_guard guard(mutex_);
  const auto found = records_.find(id);
  if (found == records_.end()) return true;
  if (found->second->taken) return false;
  forget(found->first);
  records_.erase(found);
  return true;
}

Uploads::Turn::Turn(Uploads& uploads, std::shared_ptr<Record> record)
    : uploads_(uploads),
      record_(std::move(record)),
      file_(uploads.data_of(record_->upload.id), record_->hash) {}

Uploads::Turn::~Turn() {
  const std::lock_guard guard(uploads_.mutex_);
  record_->taken = false;
  record_->upload.expires = now() + uploads_.patience_;
}

Upload Uploads::Turn::end() {
  auto upload = record_->upload;  // nobody else changes it meanwhile
  file_.sync();
  upload.offset = file_.size();
  upload.expires = now() + uploads_.patience_;
  if (upload.offset < upload.length) return upload;
  const auto found = file_.digest();
  if (upload.wanted && *upload.wanted != found) {
    const std::lock_guard guard(uploads_.mutex_);
    uploads_.forget(upload.id);
    uploads_.records_.erase(upload.id);
    throw Error(Fault::bad_input, "", other_digest(*upload.wanted, found));
  }
  uploads_.assets_.adopt(uploads_.data_of(upload.id), found);
  upload.made = found;
  uploads_.save(upload);
  const std::lock_guard guard(uploads_.mutex_);
  record_->upload = upload;
  record_->space.reset();
  uploads_.forget_oldest();
  return upload;
}

}  // namespace hoodoo::asset
