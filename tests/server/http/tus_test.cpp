#include "server/http/tus.hpp"

#include <gtest/gtest.h>

#include "engine/base/error.hpp"

using namespace hoodoo;
namespace tus = http::tus;

namespace {

const std::string abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
const std::string abc_in_base64 = "ungWv48Bz+pBQUDeXa4iI7ADYaOWF3qctBD/YfIAFa0=";
/// The digits of `abc`, in Base64.
const std::string encoded =
    "YmE3ODE2YmY4ZjAxY2ZlYTQxNDE0MGRlNWRhZTIyMjNiMDAzNjFhMzk2MTc3YTljYjQxMGZmNjFmMjAwMTVhZA==";

TEST(TusNumber, IsDigitsAlone) {
  EXPECT_EQ(tus::number("0"), 0);
  EXPECT_EQ(tus::number("9223372036854775807"), INT64_MAX);
  for (const auto* wrong : {"", "-1", "+1", " 1", "1 ", "1.0", "0x1", "5, 5", "9223372036854775808",
                            "99999999999999999999999"}) {
    EXPECT_EQ(tus::number(wrong), std::nullopt) << wrong;
  }
}
TEST(TusMetadata, NamesTheDigest) {
  EXPECT_EQ(tus::wanted_digest(""), std::nullopt);
  EXPECT_EQ(tus::wanted_digest("filename ZGVtLnRpZg==,relative"), std::nullopt);
  EXPECT_EQ(tus::wanted_digest("sha256 " + encoded), sha256("abc"));
  EXPECT_EQ(tus::wanted_digest("filename ZGVtLnRpZg==, sha256 " + encoded + ",x"), sha256("abc"));
  for (const std::string wrong :
       {"sha256", "sha256 AAAA", "sha256 A", ",", "sha256 !!!!", "a b c"}) {
    EXPECT_THROW(tus::wanted_digest(wrong), Error) << wrong;
  }
}
TEST(TusChecksum, IsOfSha256) {
  EXPECT_EQ(tus::checksum(""), std::nullopt);
  EXPECT_EQ(tus::checksum("sha256 " + abc_in_base64), Digest::parse(abc));
  for (const std::string wrong : {"sha1 AAAA", "sha256 ", "sha256 AAAA", "sha256"}) {
    EXPECT_THROW(tus::checksum(wrong), Error) << wrong;
  }
}
TEST(TusMethod, MayBeSaidByAHeaderOfAPost) {
  const auto method = [](std::string given, std::string path, std::string said) {
    http::Request request{std::move(given), std::move(path), "", {}, "", ""};
    request.headers["x-http-method-override"] = std::move(said);
    tus::override_method(request);
    return request.method;
  };
  EXPECT_EQ(method("POST", "/uploads/1", "PATCH"), "PATCH");
  EXPECT_EQ(method("POST", "/uploads/1", "GET"), "POST");
  EXPECT_EQ(method("GET", "/uploads/1", "DELETE"), "GET");
  EXPECT_EQ(method("POST", "/jobs/1", "DELETE"), "POST");
  EXPECT_EQ(method("POST", "/uploadsx", "DELETE"), "POST");
}
TEST(TusDate, IsOfTheFormOfHeaders) { EXPECT_EQ(tus::date({}), "Thu, 01 Jan 1970 00:00:00 GMT"); }

}  // namespace
