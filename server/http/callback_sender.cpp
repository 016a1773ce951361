#include <curl/curl.h>
#include <fmt/core.h>
#include <netdb.h>
#include <openssl/hmac.h>

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "server/http/courier.hpp"
#include "server/job/state.hpp"

namespace hoodoo::http {
namespace {

constexpr long connect_patience = 5000, patience = 10000;  // [ms]
constexpr std::size_t most_answer = 64u << 10;             // [bytes], all of them thrown away
constexpr std::size_t least_secret = 16, most_secret = 4096;

/// Where a target's host leads, as CURLOPT_RESOLVE wants it: "HOST:PORT:ADDRESS,...".
struct Resolved {
  std::string pin;
  Reply failure;  // where there is none
};
Resolved resolve(const Target& target, const AllowList& allowed) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const auto port = std::to_string(target.port);
  if (const int code = ::getaddrinfo(target.host.c_str(), port.c_str(), &hints, &found)) {
    return {{}, {0, false, fmt::format("{} leads nowhere: {}", target.host, gai_strerror(code))}};
  }
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> held(found, &::freeaddrinfo);
  std::string addresses;
  for (const auto* one = found; one != nullptr; one = one->ai_next) {
    const auto text = text_of(*one->ai_addr);
    if (!allowed.lets(target, *one->ai_addr)) {
      return {{}, {0, true, fmt::format("{} leads to {}, which is not public", target.host, text)}};
    }
    if (!addresses.empty()) addresses += ",";
    addresses += one->ai_family == AF_INET6 ? "[" + text + "]" : text;
  }
  const bool v6 = target.host.find(':') != target.host.npos;
  return {fmt::format("{}{}{}:{}:{}", v6 ? "[" : "", target.host, v6 ? "]" : "", target.port,
                      addresses),
          {}};
}

std::size_t throw_away(const char*, std::size_t size, std::size_t count, void* seen) {
  auto& bytes = *static_cast<std::size_t*>(seen);
  bytes += size * count;
  return bytes > most_answer ? 0 : size * count;
}

int look_for_stop(void* stop, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
  return static_cast<const std::stop_token*>(stop)->stop_requested() ? 1 : 0;
}

/// A list of curl's.
class List {
 public:
  explicit List(const std::vector<std::string>& texts) {
    for (const auto& text : texts) list_ = curl_slist_append(list_, text.c_str());
  }
  ~List() { curl_slist_free_all(list_); }
  List(const List&) = delete;
  List& operator=(const List&) = delete;
  curl_slist* get() const { return list_; }

 private:
  curl_slist* list_ = nullptr;
};

}  // namespace

std::string signature_of(const std::string& secret, const std::string& timestamp,
                         const std::string& body) {
  const auto text = timestamp + "." + body;
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned length = 0;
  ::HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()),
         reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data(), &length);
  std::string signature = "sha256=";
  for (unsigned n = 0; n < length; ++n) signature += fmt::format("{:02x}", digest[n]);
  return signature;
}

std::string read_secret(const std::filesystem::path& file) {
  auto secret = read_file(file, most_secret);
  while (secret.ends_with('\n') || secret.ends_with('\r')) secret.pop_back();
  if (secret.size() < least_secret) {
    throw Error(Fault::bad_input, file.string(),
                fmt::format("must hold a secret of {} to {} characters, got {}", least_secret,
                            most_secret, secret.size()));
  }
  return secret;
}

Sender::Sender(AllowList allowed, std::string secret)
    : allowed_(std::move(allowed)), secret_(std::move(secret)) {
  [[maybe_unused]] static const auto ready = curl_global_init(CURL_GLOBAL_DEFAULT);
}

/// The address is looked at again: the list may have changed since the job was posted.
Reply Sender::operator()(const job::Delivery& delivery, const std::stop_token& stop) const {
  const auto target = target_of(delivery.uri, "the callback");
  if (!allowed_.lets(target)) return {0, true, target.host + " may not be called"};
  const auto resolved = resolve(target, allowed_);
  if (resolved.pin.empty()) return resolved.failure;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto timestamp =
      std::to_string(std::chrono::duration_cast<std::chrono::seconds>(now).count());
  const List headers(
      {"Content-Type: application/json", "Expect:", "Hoodoo-Delivery: " + job::id_of(delivery),
       "Hoodoo-Event: " + job::name_of(delivery.event), "Hoodoo-Timestamp: " + timestamp,
       "Hoodoo-Signature: " + signature_of(secret_, timestamp, delivery.body)});
  const List pins({resolved.pin});
  std::size_t seen = 0;
  std::array<char, CURL_ERROR_SIZE> why{};
  const std::unique_ptr<CURL, decltype(&curl_easy_cleanup)> curl(curl_easy_init(),
                                                                 &curl_easy_cleanup);
  const auto set = [&curl](CURLoption option, auto value) {
    curl_easy_setopt(curl.get(), option, value);
  };
  set(CURLOPT_URL, delivery.uri.c_str());
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_RESOLVE, pins.get());
  set(CURLOPT_PROXY, "");  // of the environment's none either: it would resolve the name again
  set(CURLOPT_FOLLOWLOCATION, 0L);
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_CONNECTTIMEOUT_MS, connect_patience);
  set(CURLOPT_TIMEOUT_MS, patience);
  set(CURLOPT_USERAGENT, "hoodoo/" HOODOO_VERSION);
  set(CURLOPT_HTTPHEADER, headers.get());
  set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(delivery.body.size()));
  set(CURLOPT_POSTFIELDS, delivery.body.data());
  set(CURLOPT_WRITEFUNCTION, &throw_away);
  set(CURLOPT_WRITEDATA, &seen);
  set(CURLOPT_NOPROGRESS, 0L);
  set(CURLOPT_XFERINFOFUNCTION, &look_for_stop);
  set(CURLOPT_XFERINFODATA, &stop);
  set(CURLOPT_ERRORBUFFER, why.data());
  const auto code = curl_easy_perform(curl.get());
  long status = 0;
  curl_easy_getinfo(curl.get(), CURLINFO_RESPONSE_CODE, &status);
  if (status != 0) return {static_cast<int>(status), false, {}};
  return {0, false, why[0] != 0 ? why.data() : curl_easy_strerror(code)};
}

}  // namespace hoodoo::http
