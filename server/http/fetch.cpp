#include "server/http/fetch.hpp"

#include <fmt/core.h>

#include <chrono>
#include <exception>

#include "engine/base/error.hpp"
#include "server/http/body.hpp"
#include "server/http/outgoing.hpp"

namespace hoodoo::http {
namespace {

constexpr std::chrono::seconds most_time = std::chrono::hours(1);  // of all of it

[[noreturn]] void fail(std::string why) { throw Error(Fault::not_found, "", std::move(why)); }

/// What comes, piece by piece. No exception may pass through libcurl.
struct Coming {
  const Outgoing& from;
  const FetchUse& use;
  bool begun = false;
  std::exception_ptr thrown;

  void take(std::string_view piece) {
    if (!begun) begin();
    use.add(piece);
  }
  void begin() {
    begun = true;
    if (from.status() != 200) fail(fmt::format("is answered with {}, not 200", from.status()));
    if (from.length() < 0) fail("is answered without a Content-Length");
    use.begin(static_cast<std::uint64_t>(from.length()));
  }
};

std::size_t take(const char* bytes, std::size_t size, std::size_t count, void* to) {
  auto& coming = *static_cast<Coming*>(to);
  try {
    coming.take({bytes, size * count});
    return size * count;
  } catch (...) {
    coming.thrown = std::current_exception();
    return 0;
  }
}

}  // namespace

void fetch(const std::string& address, const AllowList& allowed, const FetchUse& use) {
  Outgoing request(address, allowed, use.stopped);
  if (request.is_refused()) {
    const auto& [may_not, why] = request.refusal();
    throw Error(may_not ? Fault::limit : Fault::not_found, "", why);
  }
  Coming coming{request, use, false, nullptr};
  request.set(CURLOPT_LOW_SPEED_LIMIT, static_cast<long>(least_rate));
  request.set(CURLOPT_LOW_SPEED_TIME, static_cast<long>(body_patience.count()));
  request.set(CURLOPT_TIMEOUT, static_cast<long>(most_time.count()));
  request.set(CURLOPT_WRITEFUNCTION, &take);
  request.set(CURLOPT_WRITEDATA, &coming);
  std::string why;
  request.perform(why);
  if (coming.thrown) std::rethrow_exception(coming.thrown);
  if (!why.empty()) fail("cannot be had: " + why);
  if (!coming.begun) coming.begin();  // nothing but a head came
}

}  // namespace hoodoo::http
