#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace hoodoo::http {

/// The whole API as an OpenAPI 3.0.3 document, for the service at `base`.
nlohmann::json openapi(const std::string& base);

}  // namespace hoodoo::http
