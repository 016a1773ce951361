#include "server/http/head.hpp"

#include <gmock/gmock.h>

using namespace hoodoo;
using http::ChunkWatch;
using http::Head;
using http::Refusal;
using testing::HasSubstr;

namespace {

std::string get(const std::string& lines = "", const std::string& line = "GET / HTTP/1.1") {
  return line + "\r\nHost: a\r\n" + lines + "\r\n";
}
/// The status of a refusal; 0 when there is none.
int refused(const std::string& head) {
  const auto read = http::read_head(head);
  const auto* refusal = std::get_if<Refusal>(&read);
  return refusal != nullptr ? refusal->status : 0;
}
Head taken(const std::string& head) { return std::get<Head>(http::read_head(head)); }

TEST(Head, IsTakenAsItIs) {
  const auto head =
      taken(get("Accept:  text/html \r\nContent-Length: 12\r\n", "PUT /a%20b?c HTTP/1.1"));
  EXPECT_EQ(head.text,
            "PUT /a%20b?c HTTP/1.1\r\nHost: a\r\nAccept: text/html\r\nContent-Length: 12\r\n\r\n");
  EXPECT_EQ(head.length, 12u);
  EXPECT_FALSE(head.chunked);
  EXPECT_TRUE(taken(get("transfer-encoding: Chunked\r\n", "POST / HTTP/1.1")).chunked);
}
TEST(Head, KeepsPercentSignsFromBeingDecoded) {
  EXPECT_THAT(taken(get("X: a%0d%0ab\r\n")).text, HasSubstr("X: a%250d%250ab\r\n"));
  EXPECT_THAT(taken(get("Referer: /a%20b\r\n")).text, HasSubstr("Referer: /a%20b\r\n"));
}
TEST(Head, GivesTokensTheCaseThatTheyAreKnownBy) {
  EXPECT_THAT(taken(get("connection: Close\r\nExpect: 100-Continue\r\n")).text,
              HasSubstr("connection: close\r\nExpect: 100-continue\r\n"));
  EXPECT_THAT(taken(get("Connection: Keep-Alive\r\n")).text, HasSubstr("Connection: Keep-Alive"));
}
TEST(Head, HidesRangesFromTheLibrary) {
  EXPECT_THAT(taken(get("RANGE: bytes=0-1\r\n")).text,
              HasSubstr("\r\nrange_within: bytes=0-1\r\n"));
  EXPECT_EQ(refused(get("range_within: bytes=0-1\r\n")), 400);
}
TEST(Head, HasOneLengthOrOneCoding) {
  for (const auto* lines :
       {"Content-Length: 1\r\nContent-Length: 1\r\n", "Content-Length: 1, 1\r\n",
        "Content-Length: +1\r\n", "Content-Length: -1\r\n", "Content-Length:\r\n",
        "Content-Length: 9223372036854775808\r\n", "Content-Length: 99999999999999999999\r\n",
        "Content-Length: 0\r\nTransfer-Encoding: chunked\r\n", "Content-Length : 1\r\n"}) {
    EXPECT_EQ(refused(get(lines)), 400) << lines;
  }
  for (const auto* lines :
       {"Transfer-Encoding: gzip\r\n", "Transfer-Encoding: gzip, chunked\r\n",
        "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n", "Transfer-Encoding:\r\n"}) {
    EXPECT_EQ(refused(get(lines)), 501) << lines;
  }
  EXPECT_EQ(refused(get("Transfer-Encoding: chunked\r\n", "POST / HTTP/1.0")), 400);
}
TEST(Head, HasLinesThatEveryReaderSeesTheSame) {
  for (const std::string& lines :
       {std::string("a: b\n"), std::string("a: b\rc: d\r\n"), std::string("a: b\r\n c\r\n"),
        std::string("a\r\n"), std::string(": b\r\n"), std::string("a_b: c\r\n"),
        std::string("a: \0\r\n", 6), std::string("a: \x7f\r\n"), std::string("a b: c\r\n"),
        std::string("Host: a\r\n")}) {
    EXPECT_EQ(refused(get(lines)), 400) << lines;
  }
  EXPECT_EQ(refused("GET / HTTP/1.1\r\n\r\n"), 400);
  EXPECT_EQ(refused("GET / HTTP/1.0\r\n\r\n"), 0);
  EXPECT_EQ(refused(get("a: caf\xc3\xa9\tb\r\n")), 0);
}
TEST(Head, HasARequestLine) {
  for (const auto* line :
       {"", "GET", "GET /", "GET  / HTTP/1.1 ", "GET /a b HTTP/1.1", "GET / HTP/1.1", " / HTTP/1.1",
        "GET /%00 HTTP/1.1", "GET /%0a HTTP/1.1", "GET /%7F HTTP/1.1", "GET /%4 HTTP/1.1",
        "GET /%zz HTTP/1.1", "GET /caf\xc3\xa9 HTTP/1.1", "G(T / HTTP/1.1"}) {
    EXPECT_EQ(refused(get("", line)), 400) << line;
  }
  EXPECT_EQ(refused(get("", "GET / HTTP/2.0")), 505);
  EXPECT_EQ(refused(get("", "TRACE / HTTP/1.1")), 501);
  EXPECT_EQ(refused(get("", "GET /" + std::string(http::most_line, 'a') + " HTTP/1.1")), 414);
  EXPECT_EQ(refused(get("", "GET /a?b=%00 HTTP/1.1")), 0);
}
TEST(Head, HasLimits) {
  std::string lines;
  for (std::size_t i = 1; i < http::most_header_lines; ++i) lines += "a: b\r\n";
  EXPECT_EQ(refused(get(lines)), 0);
  EXPECT_EQ(refused(get(lines + "a: b\r\n")), 431);
  EXPECT_EQ(refused(get("a: " + std::string(http::most_head, 'b') + "\r\n")), 431);
  EXPECT_EQ(refused(get("a: " + std::string(http::most_line / 2, '%') + "\r\n")), 431);
  EXPECT_EQ(http::wrong_so_far(std::string(http::most_head, 'a'))->status, 414);
  EXPECT_EQ(http::wrong_so_far("GET / HTTP/1.1\r\n" + std::string(http::most_head, 'a'))->status,
            431);
  EXPECT_FALSE(http::wrong_so_far("GET / HTTP/1.1\r"));
}

bool is_framed(std::string_view body) {
  ChunkWatch whole, bytes;
  bool same = true;
  for (const char c : body) same = same && bytes.see({&c, 1});
  const bool seen = whole.see(body);
  EXPECT_EQ(seen, same) << body;
  return seen && whole.ended();
}
TEST(ChunkWatch, SeesWhatIsNoFramingHoweverItComes) {
  EXPECT_TRUE(is_framed("0\r\n\r\n"));
  EXPECT_TRUE(is_framed("5\r\nhello\r\nA\r\n0123456789\r\n0\r\n\r\n"));
  for (const auto* body :
       {"-1\r\n", "+5\r\n", "0x5\r\n", " 5\r\n", "5 \r\n", "5;a=b\r\n", "5\n", "5\rx", "\r\n",
        "g\r\n", "100000000\r\n", "000000005\r\n", "5\r\nhelloworld", "5\r\nhello\n",
        "0\r\nX: y\r\n\r\n", "0\r\n\r\nx", "5\r\nhel", ""}) {
    EXPECT_FALSE(is_framed(body)) << body;
  }
}
TEST(ChunkWatch, TellsContentFromItsFraming) {
  ChunkWatch watch;
  EXPECT_FALSE(watch.in_content());
  watch.see("5\r\n");
  EXPECT_TRUE(watch.in_content());
  watch.see("hello");
  EXPECT_FALSE(watch.in_content());
}

}  // namespace
