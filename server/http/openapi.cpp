#include "server/http/openapi.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hoodoo::http {
namespace {

using nlohmann::json;

json content(const char* type, json schema) {
  return {{"content", {{type, {{"schema", std::move(schema)}}}}}};
}
json of(const char* schema) { return {{"$ref", std::string("#/components/schemas/") + schema}}; }

json answer(const char* description, const char* schema) {
  auto response = content("application/json", of(schema));
  response["description"] = description;
  return response;
}

json path_parameter(const char* name, const char* description) {
  return {{"name", name},
          {"in", "path"},
          {"required", true},
          {"description", description},
          {"schema", {{"type", "string"}}}};
}
json parameter(const char* name, const char* in, const char* description, json schema) {
  return {{"name", name},
          {"in", in},
          {"required", false},
          {"description", description},
          {"schema", std::move(schema)}};
}
const json text{{"type", "string"}};
json words(std::initializer_list<const char*> all) {
  return {{"type", "array"}, {"items", {{"type", "string"}, {"enum", all}}}};
}

/// One operation; whatever it does not list answers as a problem.
json operation(const char* id, const char* summary, json responses,
               std::vector<json> parameters = {}) {
  auto problem = content("application/problem+json", of("problem"));
  problem["description"] = "What was wrong, by RFC 9457";
  responses["default"] = std::move(problem);
  json made{{"operationId", id}, {"summary", summary}, {"responses", std::move(responses)}};
  if (!parameters.empty()) made["parameters"] = std::move(parameters);
  return made;
}

/// A header that an answer has without fail.
json always(const char* description) {
  return {{"description", description}, {"required", true}, {"schema", text}};
}

/// A document, which a client that has it need not be sent again.
json get(const char* id, const char* summary, const char* schema,
         std::vector<json> parameters = {}) {
  parameters.push_back(parameter("If-None-Match", "header", "The ETag that is known", text));
  auto found = answer(summary, schema);
  json same{{"description", "It is as it was"}};
  found["headers"]["ETag"] = same["headers"]["ETag"] =
      always("Another one whenever the document is");
  return {{"get", operation(id, summary, {{"200", std::move(found)}, {"304", std::move(same)}},
                            std::move(parameters))}};
}

json file(const char* id, const char* summary, std::vector<json> parameters) {
  const json bytes{{"type", "string"}, {"format", "binary"}};
  auto whole = content("application/octet-stream", bytes);
  whole["description"] = "The file, of its own type";
  auto part = whole;
  part["description"] = "The range of it that was asked for";
  parameters.push_back(parameter("Range", "header", "One range of bytes", text));
  parameters.push_back(parameter("If-None-Match", "header", "The ETag that is known", text));
  return {{"get",
           operation(id, summary,
                     {{"200", whole}, {"206", part}, {"304", {{"description", "It is as it was"}}}},
                     std::move(parameters))}};
}

/// A problem that a client should tell from others.
json refusal(const char* description) {
  auto problem = content("application/problem+json", of("problem"));
  problem["description"] = description;
  return problem;
}

/// One that may be sent again some time later.
json busy(const char* description) {
  auto answer = refusal(description);
  answer["headers"]["Retry-After"] = always("How many seconds later");
  return answer;
}

/// A request that this service makes: to `member` of the subscriber.
json callback(const char* id, const std::string& member, const char* summary, const char* schema) {
  const auto header = [](const char* name, const char* description) {
    return json{{"name", name},
                {"in", "header"},
                {"required", true},
                {"description", description},
                {"schema", text}};
  };
  json post{{"operationId", id},
            {"summary", summary},
            {"description", std::string(summary) + "."},
            {"tags", json::array({"jobs"})},
            {"security", json::array()},
            {"parameters",
             json::array({header("Hoodoo-Delivery", "The same each time it is sent"),
                          header("Hoodoo-Event", "inProgress, success or failed"),
                          header("Hoodoo-Timestamp", "When it was sent, in seconds since 1970"),
                          header("Hoodoo-Signature", "sha256=HEX: see subscriber")})},
            {"requestBody", content("application/json", of(schema))},
            {"responses",
             {{"2XX", {{"description", "It was taken"}}},
              {"4XX", {{"description", "As any other answer: it is sent again"}}}}}};
  post["requestBody"]["required"] = true;
  return {{"{$request.body#/subscriber/" + member + "}", {{"post", std::move(post)}}}};
}

json execution() {
  auto post = operation(
      "execute", "Carry out a process",
      {{"200", answer("Its outputs, or the job that an Idempotency-Key stands for", "anything")},
       {"201", answer("A job was made", "statusInfo")}},
      {path_parameter("processID", "Which process"),
       parameter("Prefer", "header", "respond-async", text),
       parameter("Idempotency-Key", "header",
                 "Requests of one key are one job, however often they are sent, until it has "
                 "failed or been dismissed",
                 {{"type", "string"}, {"minLength", 1}, {"maxLength", 255}})});
  post["responses"]["201"]["headers"]["Location"] = always("The job");
  auto& responses = post["responses"];
  responses["403"] = refusal("The key has no space left for results, or not this scope");
  responses["429"] = busy("As many jobs of the key wait or run as may");
  responses["503"] = busy(
      "As many jobs of all wait, or scenes are looked at, as may, or the server is about to stop");
  responses["507"] = refusal("The disk is nearly full");
  post["callbacks"] = {
      {"inProgress", callback("tellProgress", "inProgressUri", "The job has begun", "statusInfo")},
      {"success", callback("tellSuccess", "successUri", "The job has ended well", "results")},
      {"failed", callback("tellFailure", "failedUri", "The job has failed", "statusInfo")}};
  post["requestBody"] = content("application/json", of("execute"));
  post["requestBody"]["required"] = true;
  return {{"post", std::move(post)}};
}

json job_list() {
  return get(
      "getJobs", "Jobs, newest first", "jobList",
      {parameter("limit", "query", "Most jobs of a page; above 10000 it is taken as 10000",
                 {{"type", "integer"}, {"minimum", 1}, {"default", 10}}),
       parameter("status", "query", "Any of these",
                 words({"accepted", "running", "successful", "failed", "dismissed"})),
       parameter("processID", "query", "Of these processes", {{"type", "array"}, {"items", text}}),
       parameter("type", "query", "Of this type", words({"process"})),
       parameter("datetime", "query", "Made then: a time, or FROM/TO with .. for open", text),
       parameter("minDuration", "query", "Ran at least so long [s]", {{"type", "integer"}}),
       parameter("maxDuration", "query", "Ran at most so long [s]", {{"type", "integer"}}),
       parameter("before", "query", "From a link to the next page", {{"type", "integer"}})});
}

/// That an operation takes a key, where the service has any.
json key_or_none() { return json::array({json::object(), json{{"bearer", json::array()}}}); }

json one_job(const json& id) {
  auto job = get(
      "getStatus", "How far a job is", "statusInfo",
      {id, parameter("Prefer", "header", "wait=N: answer after N seconds at the latest", text)});
  job["delete"] = operation("dismiss", "Cancel a job, or remove one that has ended",
                            {{"200", answer("What became of it", "statusInfo")}}, {id});
  job["delete"]["security"] = key_or_none();
  return job;
}

/// Files are led to.
json one_result(const json& id) {
  auto path =
      get("getResult", "One of it", "anything", {id, path_parameter("outputID", "Which output")});
  json& responses = path["get"]["responses"];
  responses["303"]["description"] = "It is a file, which is there";
  responses["303"]["headers"]["Location"] = always("Where the file is");
  return path;
}

json events(const json& id) {
  auto stream = content("text/event-stream", text);
  stream["description"] = "An event with the statusInfo for every change, the last one named end";
  return {{"get",
           operation("getEvents", "Follow a job", {{"200", stream}},
                     {id, parameter("Last-Event-ID", "header", "The event that is known", text)})}};
}

json plain(const char* description, std::initializer_list<const char*> headers = {}) {
  json response{{"description", description}};
  for (const auto* name : headers) response["headers"][name] = {{"schema", text}};
  return response;
}
json required_header(const char* name, const char* description, json schema = text) {
  auto header = parameter(name, "header", description, std::move(schema));
  header["required"] = true;
  return header;
}
json binary(const char* type) {
  auto body = content(type, {{"type", "string"}, {"format", "binary"}});
  body["required"] = true;
  return body;
}

json assets() {
  auto names = parameter("id", "query", "Names of assets, sha256-HEX",
                         {{"type", "array"}, {"items", text}, {"minItems", 1}, {"maxItems", 100}});
  names["required"] = true;
  auto path = get("getAssets", "Which of some assets are there", "assets", {std::move(names)});
  path["post"] =
      operation("fetchAsset", "Fetch an elevation model from an address, where its host is listed",
                {{"200", answer("It was there", "asset")},
                 {"201", answer("It is there now", "asset")},
                 {"502", refusal("Nothing can be had from there")},
                 {"503", refusal("As much is fetched as may be at once")}});
  json where{{"type", "object"},
             {"required", {"href"}},
             {"properties",
              {{"href", {{"type", "string"}, {"format", "uri"}}},
               {"id", {{"type", "string"}, {"description", "sha256-HEX: what it must be"}}}}}};
  path["post"]["requestBody"] = content("application/json", std::move(where));
  path["post"]["requestBody"]["required"] = true;
  return path;
}

json asset() {
  const auto name = path_parameter("asset", "sha256- and the digest as 64 hexadecimal digits");
  auto path = file("getAsset", "What was put there", {name});
  path["head"] =
      operation("headAsset", "Whether it is there", {{"200", plain("It is", {"ETag"})}}, {name});
  path["put"] = operation(
      "putAsset", "Send an elevation model; with Expect: 100-continue only where it is wanted",
      {{"201", answer("It is there now", "asset")}, {"204", plain("It was there", {"ETag"})}},
      {name});
  path["put"]["requestBody"] = binary("application/octet-stream");
  path["put"]["responses"]["403"] = refusal("The key has no space left, or not this scope");
  path["delete"] = operation(
      "removeAsset", "Remove an asset of one's own, or with admin any",
      {{"204", plain("It is gone")}, {"409", refusal("A job that waits or runs needs it")}},
      {name});
  return path;
}

/// Of tus 1.0.0.
const json bytes{{"type", "integer"}, {"minimum", 0}};
json tus_version() {
  return required_header("Tus-Resumable", "The version of tus",
                         {{"type", "string"}, {"enum", {"1.0.0"}}});
}

json uploads() {
  json path;
  path["options"] = operation(
      "getUploadOptions", "What of tus there is",
      {{"204", plain("What there is",
                     {"Tus-Version", "Tus-Extension", "Tus-Max-Size", "Tus-Checksum-Algorithm"})}});
  path["post"] = operation(
      "createUpload", "Begin to send an asset in parts, by tus 1.0",
      {{"201", plain("Send them there", {"Location", "Upload-Offset", "Upload-Expires"})}},
      {tus_version(), required_header("Upload-Length", "How many bytes will come", bytes),
       parameter("Upload-Metadata", "header",
                 "Pairs of a key and Base64; sha256: the digest that is to come out", text)});
  path["post"]["responses"]["429"] = busy("As many uploads of the key are under way as may");
  path["post"]["responses"]["503"] = busy("As many uploads of all are under way as may");
  path["post"]["security"] = key_or_none();
  return path;
}

json one_upload() {
  const auto id = path_parameter("uploadID", "Which upload");
  json path;
  path["head"] =
      operation("getUpload", "How much has come",
                {{"200", plain("So much; once it is whole, with a link to the asset",
                               {"Upload-Offset", "Upload-Length", "Upload-Expires", "Link"})}},
                {id, tus_version()});
  path["patch"] = operation(
      "addToUpload", "Send the next part",
      {{"204", plain("It is there; with a link to the asset after the last",
                     {"Upload-Offset", "Upload-Expires", "Link"})}},
      {id, tus_version(), required_header("Upload-Offset", "Where the part belongs", bytes),
       parameter("Upload-Checksum", "header", "sha256 and the digest of the part in Base64",
                 text)});
  path["patch"]["requestBody"] = binary("application/offset+octet-stream");
  path["delete"] =
      operation("removeUpload", "Give it up", {{"204", plain("It is gone")}}, {id, tus_version()});
  return path;
}

json own_document() {
  auto path = get("getApi", "This document", "anything");
  auto& found = path["get"]["responses"]["200"];
  found = content("application/vnd.oai.openapi+json;version=3.0", {{"type", "object"}});
  found["description"] = "OpenAPI 3.0";
  return path;
}

json readiness() {
  auto path = get("getReadiness", "Whether requests are wanted", "health");
  path["get"]["responses"]["503"] = answer("None are: the server is about to stop", "health");
  return path;
}

json metrics() {
  auto all = content("text/plain;version=0.0.4;charset=utf-8", text);
  all["description"] = "Prometheus' text format";
  return {{"get", operation("getMetrics", "Figures for those who watch", {{"200", all}})}};
}

/// Says of a path's methods that they need a key, where the service has any.
json with_key(json path) {
  for (auto& operation : path) {
    operation["security"] = key_or_none();
  }
  return path;
}

json paths() {
  const auto job = path_parameter("jobID", "Which job");
  const auto name = path_parameter("name", "Which file, with its folders");
  return {{"/", get("getLandingPage", "What there is", "landingPage")},
          {"/conformance", get("getConformance", "What the service conforms to", "conformance")},
          {"/api", own_document()},
          {"/healthz", get("getHealth", "Whether the service lives", "health")},
          {"/readyz", readiness()},
          {"/metrics", with_key(metrics())},
          {"/processes", get("getProcesses", "What the service can do", "processList")},
          {"/processes/{processID}", get("getProcess", "A process in full", "process",
                                         {path_parameter("processID", "Which process")})},
          {"/processes/{processID}/execution", with_key(execution())},
          {"/jobs", with_key(job_list())},
          {"/jobs/{jobID}", one_job(job)},
          {"/jobs/{jobID}/events", events(job)},
          {"/jobs/{jobID}/results", get("getResults", "What a job has made", "results", {job})},
          {"/jobs/{jobID}/results/{outputID}", one_result(job)},
          {"/jobs/{jobID}/files/{name}",
           file("getFile", "A file that a job has made; of a bake tileset.3tz, all of it",
                {job, name})},
          {"/jobs/{jobID}/tiles/{name}",
           file("getTile", "A file of a job's tileset, while it runs, too", {job, name})},
          {"/assets", with_key(assets())},
          {"/assets/{asset}", with_key(asset())},
          {"/uploads", uploads()},
          {"/uploads/{uploadID}", with_key(one_upload())},
          {"/tilesets", with_key(get("getTilesets", "Finished tilesets", "tilesets"))},
          {"/tilesets/{tileset}/{name}", file("getTilesetFile", "A file of a finished tileset",
                                              {path_parameter("tileset", "Which tileset"), name})}};
}

/// What readers of the document sort operations by: the first part of their path, where it is one
/// of these, and else the first of them.
constexpr std::array<std::pair<std::string_view, std::string_view>, 5> tags{
    {{"service", "What there is, and how it fares"},
     {"processes", "What can be done"},
     {"jobs", "What is being done, and what came of it"},
     {"tilesets", "What was done before"},
     {"assets", "Files to work on"}}};
std::string_view tag_of(std::string_view path) {
  const auto found = std::ranges::find_if(
      tags, [&](const auto& tag) { return path.substr(1).starts_with(tag.first); });
  if (path.starts_with("/uploads")) return "assets";
  return found == tags.end() ? tags.front().first : found->first;
}
json tag_list() {
  json all = json::array();
  for (const auto& [name, what] : tags) all.push_back({{"name", name}, {"description", what}});
  return all;
}

/// What holds of every operation: none needs a key but those that say so, and each may be refused.
json with_defaults(json paths) {
  for (auto& [path, operations] : paths.items()) {
    for (auto& [method, operation] : operations.items()) {
      operation["tags"] = json::array({tag_of(path)});
      operation["description"] = operation["summary"].get<std::string>() + ".";
      if (!operation.contains("security")) operation["security"] = json::array();
      auto& responses = operation["responses"];
      if (method == "head") responses["default"].erase("content");
      responses["4XX"] = responses["default"];
    }
  }
  return paths;
}

}  // namespace

json openapi(const std::string& base) {
  return {
      {"openapi", "3.0.3"},
      {"info",
       {{"title", "hoodoo"},
        {"description", "Bakes terrain with real three-dimensional landforms."},
        {"version", HOODOO_VERSION},
        {"contact", {{"name", "The service"}, {"url", base}}},
        {"license",
         {{"name", "Apache 2.0"}, {"url", "https://www.apache.org/licenses/LICENSE-2.0"}}}}},
      {"servers", json::array({json{{"url", base}}})},
      {"tags", tag_list()},
      {"paths", with_defaults(paths())},
      {"components",
       {{"schemas", schemas()},
        {"securitySchemes",
         {{"bearer",
           {{"type", "http"},
            {"scheme", "bearer"},
            {"description",
             "A key with the scope read (lists, assets), submit (posting, sending and deleting) or "
             "admin"}}}}}}}};
}

}  // namespace hoodoo::http
