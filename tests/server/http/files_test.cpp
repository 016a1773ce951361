#include "server/http/files.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/server/http/few_descriptors.hpp"
#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using http::Folder;
using http::Request;
using http::serve_file;

namespace {

const std::string tile = "tiles/ab/" + std::string(64, 'a') + ".glb";

class Files : public testing::Test {
 protected:
  void SetUp() override {
    temporary.write("out/tileset.json", "{\"asset\": {}}");
    temporary.write("out/" + tile, "0123456789");
    temporary.write("out/.hoodoo/state.json", "{}");
    temporary.write("out/tiles/ab/x.part", "half");
    temporary.write("secret.json", "{}");
    std::filesystem::create_symlink("../secret.json", temporary.path / "out/link.json");
    std::filesystem::create_directory_symlink("..", temporary.path / "out/up");
    folder = {temporary.path / "out", {".json", ".glb"}};
  }
  http::Response get(std::string_view name, const std::string& header = "",
                     const std::string& value = "") {
    Request request;
    request.method = "GET";
    if (!header.empty()) request.headers[header] = value;
    return serve_file(folder, name, request);
  }
  static std::string text(const http::Response& response) {
    std::string bytes(response.part->length, ' ');
    EXPECT_EQ(::pread(*response.part->file, bytes.data(), bytes.size(),
                      static_cast<off_t>(response.part->offset)),
              static_cast<ssize_t>(bytes.size()));
    return bytes;
  }

  TemporaryFolder temporary;
  Folder folder;
};

TEST_F(Files, ComeWithTypeAndTag) {
  const auto response = get("tileset.json");
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(response.type, "application/json");
  EXPECT_EQ(text(response), "{\"asset\": {}}");
  EXPECT_EQ(response.header("Cache-Control"), "no-cache");
  EXPECT_TRUE(response.header("ETag").starts_with("\""));
}
TEST_F(Files, NamedByTheirContentMayBeKeptForEver) {
  const auto response = get(tile);
  EXPECT_EQ(response.type, "model/gltf-binary");
  EXPECT_EQ(response.header("Cache-Control"), "public, max-age=31536000, immutable");
  EXPECT_EQ(response.header("ETag"), "\"" + std::string(64, 'a') + "\"");
}
TEST_F(Files, AreNotSentAgainToWhoHasThem) {
  const std::string tag(get(tile).header("ETag"));
  EXPECT_EQ(get(tile, "if-none-match", tag).status, 304);
  EXPECT_EQ(get(tile, "if-none-match", "\"other\", W/" + tag).status, 304);
  EXPECT_EQ(get(tile, "if-none-match", "*").status, 304);
  EXPECT_EQ(get(tile, "if-none-match", "\"other\"").status, 200);
}
TEST_F(Files, ThatChangeGetAnotherTag) {
  const std::string tag(get("tileset.json").header("ETag"));
  std::filesystem::rename(temporary.write("out/next.json", "{\"asset\": []}"),
                          temporary.path / "out/tileset.json");
  EXPECT_EQ(get("tileset.json", "if-none-match", tag).status, 200);
}
TEST_F(Files, GiveOneRange) {
  const auto response = get(tile, "range", "bytes=2-4");
  EXPECT_EQ(response.status, 206);
  EXPECT_EQ(text(response), "234");
  EXPECT_EQ(response.header("Content-Range"), "bytes 2-4/10");
  EXPECT_EQ(text(get(tile, "range", "bytes=7-")), "789");
  EXPECT_EQ(text(get(tile, "range", "bytes=-4")), "6789");
  EXPECT_EQ(text(get(tile, "range", "bytes=-40")), "0123456789");
  EXPECT_EQ(text(get(tile, "range", "bytes=8-99")), "89");
  EXPECT_EQ(text(get(tile, "range", "Bytes=8-99999999999999999999")), "89");
}
TEST_F(Files, RefuseARangeThatIsNotInsideOrNotOne) {
  for (const auto* range :
       {"bytes=10-", "bytes=-0", "bytes=0-1,4-5", "bytes=0-1, -1", "bytes=99999999999999999999-"}) {
    const auto response = get(tile, "range", range);
    EXPECT_EQ(response.status, 416) << range;
    EXPECT_EQ(response.header("Content-Range"), "bytes */10") << range;
  }
}
TEST_F(Files, IgnoreWhatIsNoRangeOfBytes) {
  for (const auto* range : {"bytes=4-2", "bytes=-", "bytes=", "bytes=a-b", "bytes=0-0x", "bytes",
                            "bytes=0-1,a", "bytes=--1", "bytes=+1-2", "lines=0-1", "0-1"}) {
    EXPECT_EQ(get(tile, "range", range).status, 200) << range;
  }
}
TEST_F(Files, IgnoreARangeOfAnotherVersion) {
  Request request;
  request.method = "GET";
  request.headers = {{"range", "bytes=0-1"}, {"if-range", "\"older\""}};
  EXPECT_EQ(serve_file(folder, tile, request).status, 200);
  request.headers["if-range"] = get(tile).header("ETag");
  EXPECT_EQ(serve_file(folder, tile, request).status, 206);
}
TEST_F(Files, ThatAreHiddenForeignOrFoldersAreNotThere) {
  for (const auto* name :
       {".hoodoo/state.json", "tiles/ab/x.part", "link.json", "up/secret.json", "../secret.json",
        "tiles/../tileset.json", "/tileset.json", "tiles//ab", "tiles", "tiles/", "", ".",
        "tileset.json/", "tileset.json/x.json", "tileset.jsonx", "tile%73et.json", "nothing.json",
        "a/b/c/d/e/f/g/h/i/j/k/l/m/n/o/p/q/r.json"}) {
    EXPECT_EQ(get(name).status, 404) << name;
  }
  EXPECT_EQ(get(std::string("tileset.json\0.glb", 17)).status, 404);
  EXPECT_EQ(get(std::string(5000, 'a') + ".json").status, 404);
}
TEST_F(Files, ThatCannotBeOpenedNowAreNotSaidToBeAbsent) {
  {
    const NoMoreDescriptors none;
    const auto refused = get(tile);
    EXPECT_EQ(refused.status, 503);
    EXPECT_EQ(refused.header("Retry-After"), "1");
  }
  EXPECT_EQ(get(tile).status, 200);
}
TEST_F(Files, MayBeEmpty) {
  temporary.write("out/empty.json", "");
  const auto response = get("empty.json");
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(response.part->length, 0U);
  EXPECT_EQ(get("empty.json", "range", "bytes=0-").status, 416);
}

}  // namespace
