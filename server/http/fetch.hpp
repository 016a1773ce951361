#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "server/http/callback_target.hpp"

namespace hoodoo::http {

/// What to do with what an address holds.
struct FetchUse {
  std::function<void(std::uint64_t bytes)> begin;        // how long it is, before the first piece
  std::function<void(std::string_view piece)> add;       // in order
  std::function<bool()> stopped = [] { return false; };  // true: no more is wanted
};

/// Gets what an address of http or https holds, from hosts of the list alone, with no proxy and
/// following no redirect. The answer has to be 200 and to say how long it is; one that brings less
/// than 4 KiB/s for ten seconds, or takes more than an hour, is given up. What `use` throws goes
/// on. Errors: bad_input, it is no address; not_found, with the reason why nothing can be had from
/// there; limit, the list does not let it.
void fetch(const std::string& address, const AllowList& allowed, const FetchUse& use);

}  // namespace hoodoo::http
