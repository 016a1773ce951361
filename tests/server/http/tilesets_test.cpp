#include "server/http/tilesets.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "engine/base/error.hpp"
#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using http::Request;
using http::Tilesets;
using testing::HasSubstr;

namespace {

const std::string tile = "tiles/ab/" + std::string(64, 'a') + ".glb";

class Tileset : public testing::Test {
 protected:
  void SetUp() override {
    temporary.write("land/tileset.json", "{\"asset\": {}}");
    temporary.write("land/" + tile, "0123456789");
    archive::Writer writer(temporary.path / "rock.3tz");
    for (const auto& [name, text] :
         {std::pair<std::string, std::string_view>{"tileset.json", "{\"asset\": {}}"},
          {"bake.json", "{\"bake\": {}}"},
          {tile, "0123456789"},
          {"notes.txt", "no"}}) {
      writer.add(name, std::as_bytes(std::span(text)));
    }
    writer.finish();
    tilesets = Tilesets(std::vector{temporary.path / "land", temporary.path / "rock.3tz"});
  }
  http::Response get(std::string_view name, std::string_view file, const std::string& header = "",
                     const std::string& value = "") const {
    Request request;
    request.method = "GET";
    if (!header.empty()) request.headers[header] = value;
    return tilesets.serve(name, file, request);
  }
  static std::string text(const http::Response& response) {
    std::string bytes(response.part->length, ' ');
    EXPECT_EQ(::pread(*response.part->file, bytes.data(), bytes.size(),
                      static_cast<off_t>(response.part->offset)),
              static_cast<ssize_t>(bytes.size()));
    return bytes;
  }
  std::string refusal(const std::vector<std::filesystem::path>& paths) const {
    try {
      const Tilesets opened(paths);
    } catch (const Error& error) {
      return error.what();
    }
    return "was not refused";
  }

  TemporaryFolder temporary;
  Tilesets tilesets;
};

TEST_F(Tileset, IsKnownByTheNameOfItsFolderOrArchive) {
  EXPECT_THAT(tilesets.names(), testing::ElementsAre("land", "rock"));
  EXPECT_EQ(get("sea", "tileset.json").status, 404);
}
TEST_F(Tileset, ComesOutOfAnArchiveAsOutOfAFolder) {
  for (const auto* file : {"tileset.json", tile.c_str()}) {
    const auto packed = get("rock", file), plain = get("land", file);
    EXPECT_EQ(packed.status, 200);
    EXPECT_EQ(text(packed), text(plain));
    EXPECT_EQ(packed.type, plain.type);
    EXPECT_EQ(packed.header("Cache-Control"), plain.header("Cache-Control"));
  }
  EXPECT_EQ(get("rock", tile).header("ETag"), "\"" + std::string(64, 'a') + "\"");
}
TEST_F(Tileset, TellsFilesOfAnArchiveApart) {
  const std::string tag(get("rock", "tileset.json").header("ETag"));
  EXPECT_EQ(get("rock", "tileset.json", "if-none-match", tag).status, 304);
  EXPECT_EQ(get("rock", "bake.json", "if-none-match", tag).status, 200);
}
TEST_F(Tileset, GivesARangeWithinAFileOfAnArchive) {
  const auto part = get("rock", tile, "range", "bytes=2-4");
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(text(part), "234");
  EXPECT_EQ(part.header("Content-Range"), "bytes 2-4/10");
  EXPECT_EQ(get("rock", tile, "range", "bytes=10-").status, 416) << "not what follows it";
}
TEST_F(Tileset, ShowsNoOtherFiles) {
  for (const auto* file : {"notes.txt", "@3dtilesIndex1@", "", "../rock.3tz", "nothing.json"}) {
    EXPECT_EQ(get("rock", file).status, 404) << file;
  }
}
TEST_F(Tileset, IsRefusedWithoutAnIndexOrANameOfItsOwn) {
  temporary.write("empty/readme.txt", "");
  EXPECT_THAT(refusal({temporary.path / "empty"}), HasSubstr("empty: holds no tileset.json"));
  EXPECT_THAT(refusal({temporary.path / "nowhere"}), HasSubstr("nowhere: No such file"));
  std::filesystem::copy(temporary.path / "rock.3tz", temporary.path / "land.3tz");
  EXPECT_THAT(refusal({temporary.path / "land", temporary.path / "land.3tz"}),
              HasSubstr("land.3tz: has the name of another tileset, land"));
  std::filesystem::copy(temporary.path / "rock.3tz", temporary.path / "a b.3tz");
  EXPECT_THAT(refusal({temporary.path / "a b.3tz"}), HasSubstr("is served by its name"));
}

}  // namespace
