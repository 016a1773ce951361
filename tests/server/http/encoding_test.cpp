#include "server/http/encoding.hpp"

#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include <random>

using namespace hoodoo;
using namespace hoodoo::http;

namespace {

std::string hills(std::size_t size, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::string text;
  while (text.size() < size) text += "{\"height\": " + std::to_string(random() % 1000) + "}, ";
  text.resize(size);
  return text;
}

std::string gunzipped(const std::string& packed, std::size_t size) {
  std::string text(size + 1, '\0');
  z_stream stream{};
  EXPECT_EQ(::inflateInit2(&stream, 15 + 16), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(text.data());
  stream.avail_out = static_cast<uInt>(text.size());
  EXPECT_EQ(::inflate(&stream, Z_FINISH), Z_STREAM_END);
  text.resize(stream.total_out);
  ::inflateEnd(&stream);
  return text;
}

Request asking(std::string codings) {
  Request request;
  request.method = "GET";
  request.headers["accept-encoding"] = std::move(codings);
  return request;
}

Response answer(std::string body, std::string type = "application/json") {
  Response response;
  response.type = std::move(type);
  response.body = std::move(body);
  response.headers = {{"ETag", "\"x\""}};
  return response;
}

TEST(Coding, IsTheOneThatTheClientLikesBest) {
  for (const auto& [header, coding] : std::initializer_list<std::pair<const char*, Coding>>{
           {"", Coding::identity},
           {"identity", Coding::identity},
           {"gzip", Coding::gzip},
           {"x-gzip", Coding::gzip},
           {"GZip", Coding::gzip},
           {"gzip, deflate, br", Coding::br},
           {"gzip, br, zstd", Coding::br},
           {"gzip;q=1.0, br;q=0.9", Coding::gzip},
           {" zstd ; q=0.5 ,gzip ; Q=0.4", Coding::zstd},
           {"br;q=0, gzip;q=0.001", Coding::gzip},
           {"*", Coding::br},
           {"br;q=0, *", Coding::zstd},
           {"*;q=0", Coding::identity},
           {"gzip;q=0", Coding::identity},
           {"gzip;q=2", Coding::identity},
           {"gzip;q=-1", Coding::identity},
           {"gzip;q=nan", Coding::identity},
           {"gzip;level=9", Coding::identity},
           {"deflate", Coding::identity},
           {",,;,=", Coding::identity}}) {
    EXPECT_EQ(coding_of(header), coding) << header;
  }
}

TEST(Coding, GivesTheTextBackAndTheSameBytesEachTime) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{100'000}}) {
    const auto text = hills(size);
    EXPECT_EQ(gunzipped(encode(text, Coding::gzip), size), text);
    std::string back(size + 1, '\0');
    const auto packed = encode(text, Coding::zstd);
    back.resize(::ZSTD_decompress(back.data(), back.size(), packed.data(), packed.size()));
    EXPECT_EQ(back, text);
    for (const auto coding : {Coding::gzip, Coding::br, Coding::zstd}) {
      EXPECT_EQ(encode(text, coding), encode(text, coding));
    }
  }
}

TEST(Encoder, LeavesWhatIsSmallOrNoTextOrInParts) {
  Encoder encoder;
  const auto is_left = [&](Response response, const Request& request = asking("gzip")) {
    const auto body = response.body;
    encoder.apply(request, response);
    return response.body == body && response.header("Content-Encoding").empty();
  };
  EXPECT_FALSE(is_left(answer(hills(5000))));
  EXPECT_FALSE(is_left(answer(hills(5000), "text/javascript; charset=utf-8")));
  EXPECT_TRUE(is_left(answer(hills(1000))));
  EXPECT_TRUE(is_left(answer(hills(5000), "model/gltf-binary")));
  EXPECT_TRUE(is_left(answer(hills(5000)), asking("")));
  auto part = asking("gzip");
  part.headers["range"] = "bytes=0-5";
  EXPECT_TRUE(is_left(answer(hills(5000)), part));
  auto missing = answer(hills(5000));
  missing.status = 404;
  EXPECT_TRUE(is_left(missing));
}

TEST(Encoder, GivesEachCodingATagOfItsOwn) {
  Encoder encoder;
  auto response = answer(hills(5000));
  encoder.apply(asking("br"), response);
  EXPECT_EQ(response.header("ETag"), "\"x-br\"");
  EXPECT_EQ(response.header("Vary"), "Accept-Encoding");
  EXPECT_EQ(without_coding("\"x-br\""), without_coding("\"x\""));
  EXPECT_NE(without_coding("\"y-br\""), without_coding("\"x\""));
  Response unchanged;  // as it comes to who says "x-br"
  unchanged.status = 304;
  unchanged.type = "application/json";
  unchanged.headers = {{"ETag", "\"x\""}};
  auto request = asking("br");
  request.headers["if-none-match"] = "\"a\", \"x-br\"";
  encoder.apply(request, unchanged);
  EXPECT_EQ(unchanged.header("ETag"), "\"x-br\"");
  EXPECT_EQ(unchanged.type, "");
}

TEST(Encoder, ReadsAFileOnceAndForgetsTheLeastUsed) {
  const auto file_of = [&](const std::string& text) {
    std::FILE* file = std::tmpfile();
    std::fwrite(text.data(), 1, text.size(), file);
    std::fflush(file);
    auto held = std::make_shared<const int>(::dup(::fileno(file)));
    std::fclose(file);
    return FilePart{std::move(held), 0, text.size()};
  };
  const auto text_of = [](Encoder& encoder, const FilePart& part, const std::string& tag) {
    auto response = answer("");
    response.part = part;
    response.headers = {{"ETag", tag}};
    encoder.apply(asking("gzip"), response);
    return response.text;
  };
  const auto body_of = [&](Encoder& encoder, const FilePart& part, const std::string& tag) {
    return *text_of(encoder, part, tag);
  };
  const auto text = hills(20'000, 1), other = hills(20'000, 2);
  const auto packed = encode(text, Coding::gzip);
  const auto part = file_of(text), second = file_of(other);
  Encoder encoder(packed.size() + packed.size() / 2);  // room for one
  EXPECT_EQ(body_of(encoder, part, "\"a\""), packed);
  // The file is not looked at again while it is remembered.
  ASSERT_EQ(::ftruncate(*part.file, 0), 0);
  EXPECT_EQ(body_of(encoder, part, "\"a\""), packed);
  EXPECT_EQ(text_of(encoder, part, "\"a\""), text_of(encoder, part, "\"a\"")) << "it is shared";
  EXPECT_EQ(body_of(encoder, second, "\"b\""), encode(other, Coding::gzip));
  EXPECT_ANY_THROW(body_of(encoder, part, "\"a\""));
  ::close(*part.file);
  ::close(*second.file);
}

}  // namespace
