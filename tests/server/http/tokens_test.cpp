#include "server/http/tokens.hpp"

#include <gtest/gtest.h>

using namespace hoodoo;

namespace {

TEST(MediaType, IsComparedWithoutCaseAndParameters) {
  for (const auto* header :
       {"application/json", "Application/JSON", "application/json;charset=utf-8",
        " application/json ; charset=utf-8"}) {
    EXPECT_TRUE(http::is_media_type(header, "application/json")) << header;
  }
  for (const auto* header : {"application/jsonfoo", "application/json5;a=b", "application", "", ";",
                             "text/plain; application/json"}) {
    EXPECT_FALSE(http::is_media_type(header, "application/json")) << header;
  }
}
TEST(Token, IsTheSameInUpperAndLowerCase) {
  EXPECT_TRUE(http::same_token("KeEp-Alive", "keep-alive"));
  EXPECT_FALSE(http::same_token("keep-alive", "keep-aliv"));
  EXPECT_FALSE(http::same_token("@", "`")) << "no letters";
}

}  // namespace
