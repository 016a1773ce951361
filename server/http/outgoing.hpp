#pragma once
#include <curl/curl.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/http/callback_target.hpp"

/// Requests that the service itself makes, for courier.hpp and fetch.hpp.
namespace hoodoo::http {

/// One request by libcurl: to a host of the list alone, at the addresses that its name led to when
/// they were looked at, with no proxy and following no redirect.
class Outgoing {
 public:
  /// What keeps a request from being made.
  struct Refusal {
    bool may_not = false;  // the rules do not let it; else its host leads nowhere
    std::string why;
  };
  /// `stopped` is asked while it runs. Errors: bad_input, no address of http or https.
  Outgoing(const std::string& address, const AllowList& allowed, std::function<bool()> stopped);
  const Refusal& refusal() const { return refusal_; }
  bool is_refused() const { return !refusal_.why.empty(); }

  template <class Value>
  void set(CURLoption option, Value value) {
    curl_easy_setopt(curl_.get(), option, value);
  }
  void set_headers(const std::vector<std::string>& headers);

  /// Makes it. The status of the answer, or 0 and in `why` what went wrong.
  int perform(std::string& why);
  /// Of the answer that comes.
  int status() const;
  /// What the answer says that it is long [bytes]; negative: nothing.
  curl_off_t length() const;

 private:
  using List = std::unique_ptr<curl_slist, decltype(&curl_slist_free_all)>;
  static List list_of(const std::vector<std::string>& texts);

  std::function<bool()> stopped_;
  Refusal refusal_;
  List pins_{nullptr, &curl_slist_free_all}, headers_{nullptr, &curl_slist_free_all};
  std::unique_ptr<CURL, decltype(&curl_easy_cleanup)> curl_{nullptr, &curl_easy_cleanup};
};

}  // namespace hoodoo::http
