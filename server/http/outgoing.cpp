#include "server/http/outgoing.hpp"

#include <fmt/core.h>
#include <netdb.h>

#include <array>
#include <utility>

namespace hoodoo::http {
namespace {

constexpr long connect_patience = 5000;  // [ms]

/// Where a target's host leads, as CURLOPT_RESOLVE wants it: "HOST:PORT:ADDRESS,...".
std::string pin_of(const Target& target, const AllowList& allowed, Outgoing::Refusal& refusal) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const auto port = std::to_string(target.port);
  if (const int code = ::getaddrinfo(target.host.c_str(), port.c_str(), &hints, &found)) {
    refusal = {false, fmt::format("{} leads nowhere: {}", target.host, gai_strerror(code))};
    return {};
  }
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> held(found, &::freeaddrinfo);
  std::string addresses;
  for (const auto* one = found; one != nullptr; one = one->ai_next) {
    const auto text = text_of(*one->ai_addr);
    if (!allowed.lets(target, *one->ai_addr)) {
      refusal = {true, fmt::format("{} leads to {}, which is not public", target.host, text)};
      return {};
    }
    if (!addresses.empty()) addresses += ",";
    addresses += one->ai_family == AF_INET6 ? "[" + text + "]" : text;
  }
  const bool v6 = target.host.find(':') != target.host.npos;
  return fmt::format("{}{}{}:{}:{}", v6 ? "[" : "", target.host, v6 ? "]" : "", target.port,
                     addresses);
}

int look_for_stop(void* stopped, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
  return (*static_cast<const std::function<bool()>*>(stopped))() ? 1 : 0;
}

}  // namespace

Outgoing::List Outgoing::list_of(const std::vector<std::string>& texts) {
  curl_slist* list = nullptr;
  for (const auto& text : texts) list = curl_slist_append(list, text.c_str());
  return {list, &curl_slist_free_all};
}

Outgoing::Outgoing(const std::string& address, const AllowList& allowed,
                   std::function<bool()> stopped)
    : stopped_(std::move(stopped)) {
  [[maybe_unused]] static const auto ready = curl_global_init(CURL_GLOBAL_DEFAULT);
  const auto target = target_of(address, "");
  if (!allowed.lets(target)) {
    refusal_ = {true, target.host + " may not be called"};
    return;
  }
  const auto pin = pin_of(target, allowed, refusal_);
  if (is_refused()) return;
  pins_ = list_of({pin});
  curl_.reset(curl_easy_init());
  set(CURLOPT_URL, address.c_str());
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_RESOLVE, pins_.get());
  set(CURLOPT_PROXY, "");  // of the environment's none either: it would resolve the name again
  set(CURLOPT_FOLLOWLOCATION, 0L);
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_CONNECTTIMEOUT_MS, connect_patience);
  set(CURLOPT_USERAGENT, "hoodoo/" HOODOO_VERSION);
  set(CURLOPT_NOPROGRESS, 0L);
  set(CURLOPT_XFERINFOFUNCTION, &look_for_stop);
  set(CURLOPT_XFERINFODATA, &stopped_);
}

void Outgoing::set_headers(const std::vector<std::string>& headers) {
  headers_ = list_of(headers);
  set(CURLOPT_HTTPHEADER, headers_.get());
}

int Outgoing::perform(std::string& why) {
  std::array<char, CURL_ERROR_SIZE> text{};
  set(CURLOPT_ERRORBUFFER, text.data());
  const auto code = curl_easy_perform(curl_.get());
  set(CURLOPT_ERRORBUFFER, static_cast<char*>(nullptr));
  if (code != CURLE_OK) why = text[0] != 0 ? text.data() : curl_easy_strerror(code);
  return status();
}

int Outgoing::status() const {
  long status = 0;
  curl_easy_getinfo(curl_.get(), CURLINFO_RESPONSE_CODE, &status);
  return static_cast<int>(status);
}

curl_off_t Outgoing::length() const {
  curl_off_t length = -1;
  curl_easy_getinfo(curl_.get(), CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
  return length;
}

}  // namespace hoodoo::http
