#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "engine/base/error.hpp"
#include "server/http/message.hpp"

/// Errors as application/problem+json, RFC 9457.
namespace hoodoo::http {

/// What a fault answers when a request or a job runs into it; io is 507 where `problems` tell of a
/// lack of space, else 500.
int status_of(Fault fault, const std::vector<Problem>& problems);

/// `type` is "about:blank" unless given; `problems` become errors[{pointer, detail}], with a member
/// `parameter` or `header` in place of the pointer where the next three say so.
Response problem(int status, const std::string& detail, const std::vector<Problem>& problems = {},
                 const std::string& type = "about:blank");

/// Problems of the parameters that they name, or of the whole query; and of headers.
std::vector<Problem> in_query(std::vector<Problem> problems);
std::vector<Problem> in_headers(std::vector<Problem> problems);
/// The place of a problem with one header.
std::string header_place(const std::string& name);

/// Of a request for which its owner has no space left: `used` and `wanted` bytes are more than
/// `most`.
Response over_quota(std::uint64_t used, std::uint64_t wanted, std::uint64_t most);

/// Of a request whose body did not come whole.
Response not_received(Received how);

/// The text of a fault as a client may see it: without the folders of this machine (`hidden`), and
/// nothing but its kind when it is internal.
std::vector<Problem> shown(Fault fault, std::vector<Problem> problems,
                           const std::vector<std::string>& hidden);

}  // namespace hoodoo::http
