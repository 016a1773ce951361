#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/hash.hpp"
#include "server/http/message.hpp"

/// The words of the tus resumable upload protocol, 1.0.0 (tus.io).
namespace hoodoo::http::tus {

inline constexpr const char* version = "1.0.0";
inline constexpr const char* extensions = "creation,expiration,checksum,termination";
inline constexpr const char* content_type = "application/offset+octet-stream";

/// A path of uploads, whatever is behind it.
bool is_path(std::string_view path);
/// Makes of a POST to an upload the request that X-HTTP-Method-Override says it is.
void override_method(Request& request);

/// Of a header that is a number of bytes. None when it is absent or no such number.
std::optional<std::uint64_t> number(std::string_view header);

/// The digest under "sha256" of Upload-Metadata: its name or its hexadecimal digits. None where
/// nothing is said of it. Errors: bad_input, what is no metadata or no digest.
std::optional<Digest> wanted_digest(std::string_view metadata);
/// Of Upload-Checksum, "sha256 BASE64"; none where there is no header. Errors: bad_input.
std::optional<Digest> checksum(std::string_view header);

/// A date as headers have it: RFC 9110, 5.6.7.
std::string date(std::chrono::sys_time<std::chrono::seconds> time);

}  // namespace hoodoo::http::tus
