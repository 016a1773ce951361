#include "server/http/api.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/server/queue_engine.hpp"
#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using http::Request;
using http::Response;
using nlohmann::json;

namespace {

const std::string execution = "/processes/bake-terrain/execution";

class Api : public testing::Test {
 protected:
  Api() {
    temporary.write("viewer/index.html", "<!doctype html>");
    job::Settings settings;
    settings.data = temporary.path / "data";
    auto engine = engine_of([this](const auto& work) { return run(work); });
    engine.check = [this, plain = engine.check](const auto& file) {
      look();
      return plain(file);
    };
    queue = std::make_unique<job::Queue>(settings, std::move(engine));
    assets.emplace(temporary.path / "data", 1 << 20);
    uploads.emplace(*assets, std::chrono::seconds(60));
    http::ApiSettings api_settings;
    api_settings.base = "http://127.0.0.1:1234";
    api_settings.hosts = {"127.0.0.1:1234"};
    api_settings.viewer = temporary.path / "viewer";
    api_settings.hidden = {temporary.path.string() + "/"};
    api_settings.scene_schema = [] { return json{{"type", "object"}}; };
    api = std::make_unique<http::Api>(*queue, assets.value(), uploads.value(),
                                      std::move(api_settings));
  }

  Response ask(const std::string& method, const std::string& path, const std::string& body = "",
               const std::string& type = "application/json") {
    Request request{method, path, "", {{"host", "127.0.0.1:1234"}}, body, ""};
    if (!type.empty()) request.headers["content-type"] = type;
    return api->answer(request);
  }
  json get(const std::string& path) { return json::parse(ask("GET", path).body); }
  Response post(const json& scene) {
    return ask("POST", execution, json{{"inputs", {{"scene", scene}}}}.dump());
  }
  std::string posted(job::Status status) {
    const std::string id = json::parse(post(good_scene()).body)["jobID"];
    wait_for(*queue, id, status);
    return id;
  }

  TemporaryFolder temporary;
  std::function<job::Outcome(const job::Work&)> run = [](const auto& work) {
    std::filesystem::create_directories(work.folder / "out");
    std::ofstream(work.folder / "out/tileset.json") << "{}";
    return finished();
  };
  std::function<void()> look = [] {};  // as a scene is looked at
  std::unique_ptr<job::Queue> queue;
  std::optional<asset::Assets> assets;
  std::optional<asset::Uploads> uploads;
  std::unique_ptr<http::Api> api;
};

TEST_F(Api, AnswersAJobWithItsAbsoluteLocation) {
  const auto response = post(good_scene());
  EXPECT_EQ(response.status, 201);
  const auto info = json::parse(response.body);
  EXPECT_EQ(response.header("Location"),
            "http://127.0.0.1:1234/jobs/" + info["jobID"].get<std::string>());
  EXPECT_EQ(info["processID"], "bake-terrain");
  EXPECT_EQ(info["type"], "process");
  EXPECT_EQ(info["title"], "hill");
  for (const auto* member : {"status", "message", "progress", "created", "updated", "links"}) {
    EXPECT_TRUE(info.contains(member)) << member;
  }
}
TEST_F(Api, GivesResultsByAbsoluteReference) {
  const auto id = posted(job::Status::successful);
  const auto info = get("/jobs/" + id);
  EXPECT_EQ(info["status"], "successful");
  EXPECT_EQ(info["progress"], 100);
  EXPECT_EQ(info["tiles"]["total"], 3);
  const auto results = get("/jobs/" + id + "/results");
  EXPECT_EQ(results["tileset"]["href"], "http://127.0.0.1:1234/jobs/" + id + "/tiles/tileset.json");
  EXPECT_EQ(ask("GET", "/jobs/" + id + "/tiles/tileset.json").status, 200);
  EXPECT_EQ(get("/jobs/" + id + "/results/report")["complete"], true);
  const auto tileset = ask("GET", "/jobs/" + id + "/results/tileset");
  EXPECT_EQ(tileset.status, 303);
  EXPECT_EQ(tileset.header("Location"), results["tileset"]["href"]);
  EXPECT_EQ(ask("GET", "/jobs/" + id + "/results/log").status, 404);
}
TEST_F(Api, AnswersEveryProblemOfASceneAtItsPointer) {
  const auto response = post({{"bad", 1}});
  EXPECT_EQ(response.status, 422);
  EXPECT_EQ(response.type, "application/problem+json");
  const auto problem = json::parse(response.body);
  EXPECT_EQ(problem["status"], 422);
  EXPECT_EQ(problem["errors"][0]["pointer"], "/bad");
  EXPECT_EQ(problem["errors"][0]["detail"], "is an unknown key");
}
TEST_F(Api, AnswersABodyThatIsNoJobWithWhatIsWrong) {
  for (const auto* body :
       {"", "{", "[]", "3", "{}", "{\"inputs\": 1}", "{\"inputs\": {}}",
        "{\"inputs\": {\"scene\": 1}}", "{\"inputs\": {\"scene\": {}, \"dem\": {}}}",
        "{\"inputs\": {\"scene\": {}}, \"subscriber\": {}}",
        "{\"inputs\": {\"scene\": {}}, \"response\": \"raw\"}", "{\"a\": 1, \"a\": 2}"}) {
    const auto response = ask("POST", execution, body);
    EXPECT_EQ(response.status, 400) << body;
    EXPECT_TRUE(json::parse(response.body).contains("errors")) << body;
  }
  EXPECT_EQ(ask("POST", execution, std::string(100'000, '[')).status, 413);
}
TEST_F(Api, TakesAJobAsJsonOnly) {
  EXPECT_EQ(ask("POST", execution, "{}", "text/plain").status, 415);
  EXPECT_EQ(ask("POST", execution, "{}", "").status, 415);
  EXPECT_EQ(post(good_scene()).status, 201);
}
TEST_F(Api, LooksAtFourScenesAtOnceAndKeepsOthersWaitingForATimeOnly) {
  std::atomic<bool> go_on = false;
  std::atomic<int> looking = 0;
  look = [&] {
    ++looking;
    while (!go_on) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  std::array<std::future<Response>, 4> slow;
  for (auto& one : slow) one = std::async(std::launch::async, [&] { return post(good_scene()); });
  while (looking < 4) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  Request echo{"POST", "/processes/echo/execution", "", {{"host", "127.0.0.1:1234"}}, "", ""};
  echo.headers.insert({{"content-type", "application/json"}, {"prefer", "respond-async"}});
  echo.body = json{{"inputs", {{"echo", 1}}}}.dump();
  EXPECT_EQ(api->answer(echo).status, 201) << "of which there is no scene";
  const auto refused = post(good_scene());
  EXPECT_EQ(refused.status, 503);
  EXPECT_EQ(refused.header("Retry-After"), "5");
  EXPECT_EQ(looking, 4);
  go_on = true;
  for (auto& one : slow) EXPECT_EQ(one.get().status, 201);
}
TEST_F(Api, SaysThatResultsAreNotReady) {
  run = until_stopped;
  const auto id = posted(job::Status::running);
  const auto response = ask("GET", "/jobs/" + id + "/results");
  EXPECT_EQ(response.status, 404);
  EXPECT_TRUE(json::parse(response.body)["type"].get<std::string>().ends_with("result-not-ready"));
}
TEST_F(Api, CancelsAJob) {
  run = until_stopped;
  const auto id = posted(job::Status::running);
  const auto response = ask("DELETE", "/jobs/" + id);
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(json::parse(response.body)["status"], "dismissed");
  EXPECT_EQ(ask("GET", "/jobs/" + id + "/results").status, 409);
}
TEST_F(Api, AnswersAFailedJobsResultsWithTheKindOfItsFailure) {
  run = [](const auto&) -> job::Outcome {
    throw Error(Fault::limit, "/terrains/0", "is too large");
  };
  const auto id = posted(job::Status::failed);
  EXPECT_EQ(get("/jobs/" + id)["errors"][0]["detail"], "is too large");
  EXPECT_EQ(ask("GET", "/jobs/" + id + "/results").status, 413);
}
TEST_F(Api, TellsALackOfSpaceFromOtherFaultsOfTheDisk) {
  const auto status_of = [this](const std::string& what) {
    run = [what](const auto&) -> job::Outcome { throw Error(Fault::io, "out/a.glb", what); };
    return ask("GET", "/jobs/" + posted(job::Status::failed) + "/results").status;
  };
  EXPECT_EQ(status_of("No space left on device"), 507);
  EXPECT_EQ(status_of("database or disk is full"), 507);
  EXPECT_EQ(status_of("Input/output error"), 500);
}
TEST_F(Api, RefusesMoreOutputsThanThereAre) {
  json body{{"inputs", {{"scene", good_scene()}}}};
  for (int n = 0; n < 100'000; ++n) body["outputs"]["o" + std::to_string(n)] = json::object();
  const auto response = ask("POST", execution, body.dump());
  EXPECT_EQ(response.status, 400);
  const auto errors = json::parse(response.body)["errors"];
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0]["pointer"], "/outputs");
}
TEST_F(Api, NamesTheJobInTheTagOfItsStatus) {
  const auto id = posted(job::Status::successful);
  EXPECT_NE(ask("GET", "/jobs/" + id).header("ETag").find(id), std::string::npos);
}
TEST_F(Api, ShowsNoFolderOfTheMachineAndNoInternalError) {
  run = [this](const auto&) -> job::Outcome {
    throw Error(Fault::not_found, (temporary.path / "dems/a.tif").string(), "is gone");
  };
  auto id = posted(job::Status::failed);
  EXPECT_EQ(get("/jobs/" + id)["errors"][0]["pointer"], "dems/a.tif");
  EXPECT_EQ(ask("GET", "/jobs/" + id).body.find(temporary.path), std::string::npos);
  run = [](const auto&) -> job::Outcome { throw std::runtime_error("0xdeadbeef"); };
  id = posted(job::Status::failed);
  EXPECT_EQ(get("/jobs/" + id)["errors"][0]["detail"], "internal error");
  EXPECT_EQ(ask("GET", "/jobs/" + id + "/results").status, 500);
}
TEST_F(Api, ListsJobsNewestFirst) {
  const auto first = posted(job::Status::successful), second = posted(job::Status::successful);
  const auto jobs = get("/jobs")["jobs"];
  ASSERT_EQ(jobs.size(), 2U);
  EXPECT_EQ(jobs[0]["jobID"], second);
}
TEST_F(Api, KnowsItsProcessesAndNoOther) {
  EXPECT_EQ(get("/processes")["processes"][0]["id"], "bake-terrain");
  EXPECT_EQ(get("/processes/bake-terrain")["inputs"]["scene"]["schema"]["type"], "object");
  EXPECT_EQ(ask("GET", "/processes/nothing").status, 404);
  EXPECT_EQ(ask("POST", "/processes/nothing/execution", "{}").status, 404);
}
TEST_F(Api, HasAbsoluteLinksOnly) {
  for (const auto* path : {"/", "/processes", "/processes/bake-terrain", "/jobs"}) {
    const auto answer = get(path);
    for (const auto& link : answer["links"]) {
      EXPECT_TRUE(link["href"].get<std::string>().starts_with("http://127.0.0.1:1234/")) << path;
    }
  }
  EXPECT_TRUE(get("/conformance")["conformsTo"].is_array());
  EXPECT_EQ(get("/healthz")["status"], "ok");
}
TEST_F(Api, SaysWhatAPathTakes) {
  const auto refused = ask("PUT", "/jobs");
  EXPECT_EQ(refused.status, 405);
  EXPECT_EQ(refused.header("Allow"), "GET, HEAD, OPTIONS");
  EXPECT_EQ(ask("OPTIONS", "/jobs/x").header("Allow"), "GET, HEAD, DELETE, OPTIONS");
}
TEST_F(Api, LetsPagesOfOtherOriginsReadAJobButNotListOrPost) {
  const auto id = posted(job::Status::successful);
  EXPECT_EQ(ask("GET", "/jobs/" + id).header("Access-Control-Allow-Origin"), "*");
  EXPECT_EQ(ask("GET", "/jobs/" + id + "/tiles/tileset.json").header("Access-Control-Allow-Origin"),
            "*");
  EXPECT_EQ(ask("OPTIONS", "/jobs/" + id).header("Access-Control-Allow-Methods"), "GET, HEAD");
  EXPECT_EQ(ask("GET", "/jobs").header("Access-Control-Allow-Origin"), "");
  EXPECT_EQ(ask("OPTIONS", execution).header("Access-Control-Allow-Origin"), "");
}
TEST_F(Api, AnswersForItsOwnHostOnly) {
  Request request{"GET", "/healthz", "", {{"host", "evil.example:1234"}}, "", ""};
  EXPECT_EQ(api->answer(request).status, 421);
  request.headers.clear();
  EXPECT_EQ(api->answer(request).status, 421);
}
TEST_F(Api, ServesTheViewer) {
  EXPECT_EQ(ask("GET", "/viewer/").status, 200);
  EXPECT_EQ(ask("GET", "/viewer/").type, "text/html; charset=utf-8");
  EXPECT_EQ(ask("GET", "/viewer").header("Location"), "http://127.0.0.1:1234/viewer/");
  EXPECT_EQ(ask("GET", "/viewer/../data/lock").status, 404);
}
TEST_F(Api, HasNothingElsewhere) {
  for (const auto* path : {"/nothing", "/jobs/", "/jobs/../jobs", "//jobs", "/jobs/x", "jobs", "",
                           "/jobs/x/tiles/tileset.json", "/jobs/x/results", "/jobs/*"}) {
    EXPECT_EQ(ask("GET", path).status, 404) << path;
  }
  EXPECT_EQ(ask("DELETE", "/jobs/x").status, 404);
  EXPECT_EQ(ask("GET", "/" + std::string(2000, 'a')).status, 414);
}

}  // namespace
