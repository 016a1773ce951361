#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace hoodoo::http {

/// The whole API as an OpenAPI 3.0.3 document, for the service at `base`.
nlohmann::json openapi(const std::string& base);

/// Its schemas: those of OGC API - Processes 1.0, with what this service adds.
nlohmann::json schemas();

}  // namespace hoodoo::http
