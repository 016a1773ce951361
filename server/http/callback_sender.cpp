#include <fmt/core.h>
#include <openssl/hmac.h>

#include <array>
#include <utility>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "server/http/courier.hpp"
#include "server/http/outgoing.hpp"
#include "server/job/state.hpp"

namespace hoodoo::http {
namespace {

constexpr long patience = 10000;                // [ms]
constexpr std::size_t most_answer = 64u << 10;  // [bytes], all of them thrown away
constexpr std::size_t least_secret = 16, most_secret = 4096;

std::size_t throw_away(const char*, std::size_t size, std::size_t count, void* seen) {
  auto& bytes = *static_cast<std::size_t*>(seen);
  bytes += size * count;
  return bytes > most_answer ? 0 : size * count;
}

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
    : allowed_(std::move(allowed)), secret_(std::move(secret)) {}

/// The address is looked at again: the list may have changed since the job was posted.
Reply Sender::operator()(const job::Delivery& delivery, const std::stop_token& stop) const {
  Outgoing request(delivery.uri, allowed_, [&stop] { return stop.stop_requested(); });
  if (request.is_refused()) return {0, request.refusal().may_not, request.refusal().why};
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto timestamp =
      std::to_string(std::chrono::duration_cast<std::chrono::seconds>(now).count());
  request.set_headers(
      {"Content-Type: application/json", "Expect:", "Hoodoo-Delivery: " + job::id_of(delivery),
       "Hoodoo-Event: " + job::name_of(delivery.event), "Hoodoo-Timestamp: " + timestamp,
       "Hoodoo-Signature: " + signature_of(secret_, timestamp, delivery.body)});
  std::size_t seen = 0;
  request.set(CURLOPT_TIMEOUT_MS, patience);
  request.set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(delivery.body.size()));
  request.set(CURLOPT_POSTFIELDS, delivery.body.data());
  request.set(CURLOPT_WRITEFUNCTION, &throw_away);
  request.set(CURLOPT_WRITEDATA, &seen);
  std::string why;
  const int status = request.perform(why);
  if (status != 0) return {status, false, {}};
  return {0, false, why};
}

}  // namespace hoodoo::http
