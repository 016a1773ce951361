#pragma once
#include <netinet/in.h>

#include <optional>
#include <string>
#include <vector>

/// Whom the service itself may ask: for callbacks, and for elevations.
namespace hoodoo::http {

/// Where an address of http or https leads.
struct Target {
  std::string scheme, host;  // lower case; an IPv6 address without brackets
  int port = 0;
  bool usual_port = false;  // of the scheme
};

/// Errors: bad_input, where `at` is, for what is no such address or holds a name or a password.
Target target_of(const std::string& address, const std::string& at);

/// False for what leads nowhere in the Internet: private, shared (RFC 6598), loopback, link-local,
/// multicast, documentation and reserved ranges, and IPv6 that stands for any IPv4 address.
bool is_public(const in_addr& address);
bool is_public(const in6_addr& address);

/// The hosts that may be called: "HOST:PORT", or "HOST" for the usual port of a scheme.
class AllowList {
 public:
  AllowList() = default;  // nobody
  /// Errors: bad_input, at `option`, which the entries came by.
  AllowList(const std::vector<std::string>& entries, const std::string& option);

  bool empty() const { return entries_.empty(); }
  bool lets(const Target& target) const;
  /// Whether a connection for `target` may go to this address, to which its host leads: one that is
  /// public, or that an entry names literally.
  bool lets(const Target& target, const sockaddr& address) const;

 private:
  struct Entry {
    std::string host;
    std::optional<int> port;
    bool fits(const std::string& name, const Target& target) const;
  };
  std::vector<Entry> entries_;
};

/// The text of an address that a socket can connect to.
std::string text_of(const sockaddr& address);

}  // namespace hoodoo::http
