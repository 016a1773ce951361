#pragma once
#include <httplib.h>

#include <stop_token>

#include "server/http/message.hpp"

namespace hoodoo::http {

/// All but the body. Names of headers are in lower case, and of several lines one value is made.
Request read_head(const httplib::Request& from);

/// Waits for an answer that comes later, which hears of `stop`; files and streams are sent piece by
/// piece afterwards.
void write(Response&& from, httplib::Response& to, const std::stop_token& stop = {});

}  // namespace hoodoo::http
