#pragma once
#include <string>

#include "server/http/message.hpp"

/// Answers without the HTTP library, to connections that it does not serve any more, or never did.
namespace hoodoo::http {

/// Now, as an answer has it.
std::string date();

/// An answer with its body, after which the connection closes.
std::string last_words(const Response& response);

/// For a connection that there is no room for.
Response too_many();

}  // namespace hoodoo::http
