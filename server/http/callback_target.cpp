#include "server/http/callback_target.hpp"

#include <arpa/inet.h>
#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include "engine/base/error.hpp"

namespace hoodoo::http {
namespace {

constexpr std::size_t longest_address = 2048;

struct Network {
  std::uint32_t start;
  int bits;
};
/// IANA's registry of special-purpose addresses, and multicast.
constexpr std::array<Network, 15> special{{{0x00000000, 8},
                                           {0x0a000000, 8},   // private
                                           {0x64400000, 10},  // shared by customers of a carrier
                                           {0x7f000000, 8},   // loopback
                                           {0xa9fe0000, 16},  // link-local
                                           {0xac100000, 12},  // private
                                           {0xc0000000, 24},
                                           {0xc0000200, 24},   // documentation
                                           {0xc0586300, 24},   // 6to4 relays
                                           {0xc0a80000, 16},   // private
                                           {0xc6120000, 15},   // benchmarks
                                           {0xc6336400, 24},   // documentation
                                           {0xcb007100, 24},   // documentation
                                           {0xe0000000, 4},    // multicast
                                           {0xf0000000, 4}}};  // reserved, broadcast

std::string lower(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

/// One writing of each IPv6 address; without brackets.
std::string plain_host(std::string host) {
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  in6_addr address{};
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (::inet_pton(AF_INET6, host.c_str(), &address) != 1) return lower(host);
  return ::inet_ntop(AF_INET6, &address, text.data(), text.size());
}

/// An address taken apart by curl, which is to go there: no second reader, no second meaning.
class Parsed {
 public:
  Parsed(const std::string& address, const std::string& at) : url_(curl_url(), &curl_url_cleanup) {
    if (address.size() > longest_address) {
      throw Error(Fault::bad_input, at,
                  "must be at most " + std::to_string(longest_address) + " characters long");
    }
    const auto code = curl_url_set(url_.get(), CURLUPART_URL, address.c_str(), CURLU_DISALLOW_USER);
    if (code == CURLUE_USER_NOT_ALLOWED || !part(CURLUPART_PASSWORD).empty()) {
      throw Error(Fault::bad_input, at, "may hold neither a user nor a password");
    }
    const auto scheme = part(CURLUPART_SCHEME);
    if (code != CURLUE_OK || (scheme != "http" && scheme != "https") ||
        !part(CURLUPART_ZONEID).empty()) {
      throw Error(Fault::bad_input, at, "must be an address of http or https");
    }
  }
  std::string part(CURLUPart which, unsigned flags = 0) const {
    char* text = nullptr;
    if (curl_url_get(url_.get(), which, &text, flags) != CURLUE_OK) return {};
    const std::unique_ptr<char, decltype(&curl_free)> held(text, &curl_free);
    return text;
  }

 private:
  std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> url_;
};

}  // namespace

Target target_of(const std::string& address, const std::string& at) {
  const Parsed parsed(address, at);
  Target target{parsed.part(CURLUPART_SCHEME), plain_host(parsed.part(CURLUPART_HOST)), 0, false};
  target.port = std::stoi(parsed.part(CURLUPART_PORT, CURLU_DEFAULT_PORT));
  target.usual_port = target.port == (target.scheme == "https" ? 443 : 80);
  return target;
}

bool is_public(const in_addr& address) {
  const std::uint32_t bits = ntohl(address.s_addr);
  return std::ranges::none_of(special, [bits](const Network& network) {
    return ((bits ^ network.start) >> (32 - network.bits)) == 0;
  });
}

bool is_public(const in6_addr& address) {
  const auto& bytes = address.s6_addr;
  if ((bytes[0] & 0xe0) != 0x20) return false;  // 2000::/3 is all that is given out
  const auto start = std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
                     std::uint32_t{bytes[2]} << 8 | std::uint32_t{bytes[3]};
  if (start >> 16 == 0x2002) return false;                        // 6to4: an IPv4 address
  if (start >> 9 == 0x20010000 >> 9) return false;                // Teredo and other protocols
  return start != 0x20010db8 && start >> 12 != 0x3fff0000 >> 12;  // documentation
}

AllowList::AllowList(const std::vector<std::string>& entries, const std::string& at) {
  for (const auto& entry : entries) {
    const bool plain = std::ranges::all_of(entry, [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
             std::strchr(".-_:[]", c) != nullptr;
    });
    const auto wrong = [&] {
      return Error(Fault::bad_input, at, "must be HOST or HOST:PORT, got \"" + entry + "\"");
    };
    if (!plain || entry.empty() || entry.find("::") == 0) throw wrong();
    try {
      const Parsed parsed("http://" + entry + "/", at);
      const auto port = parsed.part(CURLUPART_PORT);
      Entry made{plain_host(parsed.part(CURLUPART_HOST)), std::nullopt};
      if (!port.empty()) made.port = std::stoi(port);
      entries_.push_back(std::move(made));
    } catch (const Error&) {
      throw wrong();
    }
  }
}

bool AllowList::Entry::fits(const std::string& name, const Target& target) const {
  return name == host && (port ? *port == target.port : target.usual_port);
}

bool AllowList::lets(const Target& target) const {
  return std::ranges::any_of(entries_,
                             [&](const Entry& entry) { return entry.fits(target.host, target); });
}

bool AllowList::lets(const Target& target, const sockaddr& address) const {
  if (address.sa_family == AF_INET &&
      is_public(reinterpret_cast<const sockaddr_in&>(address).sin_addr)) {
    return true;
  }
  if (address.sa_family == AF_INET6 &&
      is_public(reinterpret_cast<const sockaddr_in6&>(address).sin6_addr)) {
    return true;
  }
  const auto text = text_of(address);
  return std::ranges::any_of(entries_,
                             [&](const Entry& entry) { return entry.fits(text, target); });
}

std::string text_of(const sockaddr& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const void* bytes = nullptr;
  if (address.sa_family == AF_INET) bytes = &reinterpret_cast<const sockaddr_in&>(address).sin_addr;
  if (address.sa_family == AF_INET6) {
    bytes = &reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
  }
  if (bytes == nullptr) return {};
  return ::inet_ntop(address.sa_family, bytes, text.data(), text.size());
}

}  // namespace hoodoo::http
