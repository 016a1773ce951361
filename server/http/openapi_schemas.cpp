#include <nlohmann/json.hpp>

#include "server/http/openapi.hpp"

namespace hoodoo::http {
namespace {

/// Schemas of OGC API - Processes 1.0 with what this service adds.
constexpr const char* text = R"({
"link": {"type": "object", "required": ["href"], "properties": {
  "href": {"type": "string", "format": "uri"}, "rel": {"type": "string"}, "type": {"type": "string"},
  "title": {"type": "string"}}},
"links": {"type": "array", "items": {"$ref": "#/components/schemas/link"}},
"landingPage": {"type": "object", "required": ["links"], "properties": {
  "title": {"type": "string"}, "description": {"type": "string"},
  "links": {"$ref": "#/components/schemas/links"}}},
"conformance": {"type": "object", "required": ["conformsTo"], "properties": {
  "conformsTo": {"type": "array", "items": {"type": "string", "format": "uri"}}}},
"processSummary": {"type": "object", "required": ["id", "version"], "properties": {
  "id": {"type": "string"}, "version": {"type": "string"}, "title": {"type": "string"},
  "description": {"type": "string"},
  "jobControlOptions": {"type": "array", "items": {
    "type": "string", "enum": ["sync-execute", "async-execute", "dismiss"]}},
  "outputTransmission": {"type": "array", "items": {"type": "string", "enum": ["value", "reference"]}},
  "links": {"$ref": "#/components/schemas/links"}}},
"processList": {"type": "object", "required": ["processes", "links"], "properties": {
  "processes": {"type": "array", "items": {"$ref": "#/components/schemas/processSummary"}},
  "links": {"$ref": "#/components/schemas/links"}}},
"description": {"type": "object", "required": ["schema"], "properties": {
  "title": {"type": "string"}, "description": {"type": "string"}, "schema": {"type": "object"},
  "minOccurs": {"type": "integer"}, "maxOccurs": {"type": "integer"}}},
"process": {"allOf": [{"$ref": "#/components/schemas/processSummary"}, {"type": "object",
  "required": ["inputs", "outputs"], "properties": {
    "inputs": {"type": "object", "additionalProperties": {"$ref": "#/components/schemas/description"}},
    "outputs": {"type": "object", "additionalProperties": {"$ref": "#/components/schemas/description"}}}}]},
"execute": {"type": "object", "required": ["inputs"], "additionalProperties": false, "properties": {
  "processID": {"type": "string", "description": "As the path says"},
  "inputs": {"type": "object"},
  "outputs": {"type": "object", "description": "Those that are wanted; all where there are none",
    "additionalProperties": {"type": "object", "properties": {
      "transmissionMode": {"type": "string", "enum": ["value", "reference"]}}}},
  "response": {"type": "string", "enum": ["raw", "document"], "default": "document"},
  "priority": {"type": "integer", "minimum": -10, "maximum": 10, "default": 0},
  "subscriber": {"$ref": "#/components/schemas/subscriber"}}},
"subscriber": {"type": "object", "required": ["successUri"], "additionalProperties": false,
  "description": "Who is told of a job, where this service makes callbacks: addresses of hosts that it may call. Each callback is sent until it is answered with 2xx, six times at most. Hoodoo-Delivery names it, the same each time; Hoodoo-Event is inProgress, success or failed; Hoodoo-Signature is sha256= and the HMAC-SHA256 of Hoodoo-Timestamp, a full stop and the body.",
  "properties": {"successUri": {"type": "string", "format": "uri", "maxLength": 2048},
    "inProgressUri": {"type": "string", "format": "uri", "maxLength": 2048},
    "failedUri": {"type": "string", "format": "uri", "maxLength": 2048}}},
"statusCode": {"type": "string", "enum": ["accepted", "running", "successful", "failed", "dismissed"]},
"error": {"type": "object", "required": ["detail"], "properties": {
  "pointer": {"type": "string", "description": "A JSON Pointer into the scene or the body"},
  "parameter": {"type": "string", "description": "Of the query"},
  "header": {"type": "string"}, "detail": {"type": "string"}}},
"statusInfo": {"type": "object",
  "required": ["jobID", "id", "processID", "processingEntityType", "status", "type"], "properties": {
  "id": {"type": "string", "pattern": "^[0-9a-f]{32}$"},
  "processingEntityType": {"type": "string", "enum": ["ogc-api-processes"]},
  "secondsLeft": {"type": "integer", "minimum": 0,
    "description": "An estimate, while tiles are baked and once their pace is known"},
  "finishedTiles": {"type": "array", "maxItems": 256, "description": "In events alone: since the one before",
    "items": {"type": "object", "required": ["tile", "box"], "properties": {
      "tile": {"type": "string", "pattern": "^[0-9]+/-?[0-9]+/-?[0-9]+$"},
      "box": {"type": "array", "minItems": 6, "maxItems": 6, "items": {"type": "number"},
        "description": "Least and greatest x, y and z in metres of the scene"}}}},
  "processID": {"type": "string"}, "type": {"type": "string", "enum": ["process"]},
  "jobID": {"type": "string", "pattern": "^[0-9a-f]{32}$"},
  "status": {"$ref": "#/components/schemas/statusCode"},
  "message": {"type": "string"}, "title": {"type": "string"},
  "created": {"type": "string", "format": "date-time"}, "started": {"type": "string", "format": "date-time"},
  "finished": {"type": "string", "format": "date-time"}, "updated": {"type": "string", "format": "date-time"},
  "progress": {"type": "integer", "minimum": 0, "maximum": 100},
  "priority": {"type": "integer"}, "phase": {"type": "string", "enum": ["ingest", "tiles", "index", "done"]},
  "tiles": {"type": "object", "required": ["done", "total", "reused", "cached"], "properties": {
    "done": {"type": "integer"}, "total": {"type": "integer"}, "reused": {"type": "integer"},
    "cached": {"type": "integer"}}},
  "triangles": {"type": "integer"}, "bytes": {"type": "integer"},
  "errors": {"type": "array", "items": {"$ref": "#/components/schemas/error"}},
  "links": {"$ref": "#/components/schemas/links"}}},
"jobList": {"type": "object", "required": ["jobs", "links"], "properties": {
  "jobs": {"type": "array", "items": {"$ref": "#/components/schemas/statusInfo"}},
  "links": {"$ref": "#/components/schemas/links"}}},
"results": {"type": "object"},
"anything": {"description": "An output by itself, or a document of them"},
"problem": {"type": "object", "required": ["type", "title", "status", "detail"], "properties": {
  "type": {"type": "string"}, "title": {"type": "string"}, "status": {"type": "integer"},
  "detail": {"type": "string"}, "instance": {"type": "string"},
  "errors": {"type": "array", "items": {"$ref": "#/components/schemas/error"}}}},
"tilesets": {"type": "object", "required": ["tilesets"], "properties": {
  "tilesets": {"type": "array", "items": {"type": "object", "required": ["name", "href", "viewer"],
    "properties": {"name": {"type": "string"}, "href": {"type": "string", "format": "uri"},
      "viewer": {"type": "string", "format": "uri"}}}}}},
"asset": {"type": "object", "required": ["id", "href", "bytes"], "properties": {
  "id": {"type": "string", "pattern": "^sha256-[0-9a-f]{64}$"}, "href": {"type": "string", "format": "uri"},
  "bytes": {"type": "integer", "minimum": 0}}},
"assets": {"type": "object", "required": ["assets"], "properties": {
  "assets": {"type": "array", "items": {"$ref": "#/components/schemas/asset"}}}},
"health": {"type": "object", "required": ["status"], "properties": {"status": {"type": "string"}}}
})";

}  // namespace

nlohmann::json schemas() { return nlohmann::json::parse(text); }

}  // namespace hoodoo::http
