#include <arpa/inet.h>
#include <gtest/gtest.h>

#include <atomic>

#include "engine/base/error.hpp"
#include "server/http/courier.hpp"
#include "tests/server/queue_engine.hpp"
#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using http::AllowList;
using http::target_of;

namespace {

bool is_public_v4(const std::string& text) {
  in_addr address{};
  EXPECT_EQ(::inet_pton(AF_INET, text.c_str(), &address), 1) << text;
  return http::is_public(address);
}
bool is_public_v6(const std::string& text) {
  in6_addr address{};
  EXPECT_EQ(::inet_pton(AF_INET6, text.c_str(), &address), 1) << text;
  return http::is_public(address);
}
bool lets(const AllowList& list, const std::string& uri, const std::string& address) {
  sockaddr_in v4{};
  v4.sin_family = AF_INET;
  sockaddr_in6 v6{};
  v6.sin6_family = AF_INET6;
  if (::inet_pton(AF_INET, address.c_str(), &v4.sin_addr) == 1) {
    return list.lets(target_of(uri, ""), reinterpret_cast<const sockaddr&>(v4));
  }
  EXPECT_EQ(::inet_pton(AF_INET6, address.c_str(), &v6.sin6_addr), 1) << address;
  return list.lets(target_of(uri, ""), reinterpret_cast<const sockaddr&>(v6));
}

TEST(CallbackTarget, IsAnAddressOfHttpWithoutCredentials) {
  const auto plain = target_of("http://Hooks.Example/a?b", "/x");
  EXPECT_EQ(plain.host, "hooks.example");
  EXPECT_EQ(plain.port, 80);
  EXPECT_TRUE(plain.usual_port);
  const auto other = target_of("https://[2001:DB8:0::1]:8443/", "/x");
  EXPECT_EQ(other.host, "2001:db8::1");
  EXPECT_EQ(other.port, 8443);
  EXPECT_FALSE(other.usual_port);
  for (const std::string wrong :
       {"", "hooks.example", "/a", "ftp://a/", "file:///etc/passwd", "gopher://a/", "http://",
        "http://u@a/", "http://u:p@a/", "http://:p@a/", "http://a:99999/", "http://a b/",
        "http://a\r\nX: y/", "http://[fe80::1%25eth0]/", "unix:/run/x"}) {
    try {
      target_of(wrong, "/x");
      ADD_FAILURE() << wrong;
    } catch (const Error& error) {
      EXPECT_EQ(error.fault, Fault::bad_input);
      EXPECT_EQ(error.problems.front().where, "/x");
    }
  }
  EXPECT_THROW(target_of("http://a/" + std::string(3000, 'a'), ""), Error);
}

TEST(CallbackTarget, HasOneWritingOfAnAddress) {
  for (const auto* text : {"http://127.0.0.1/", "http://2130706433/", "http://0x7f.1/",
                           "http://0177.0.0.1/", "http://127.1/"}) {
    EXPECT_EQ(target_of(text, "").host, "127.0.0.1") << text;
  }
}

TEST(PublicAddress, IsNoneOfTheSpecialRanges) {
  for (const auto* text : {"8.8.8.8", "1.1.1.1", "172.15.255.255", "172.32.0.0", "100.63.255.255",
                           "100.128.0.0", "169.253.0.1", "223.255.255.255", "192.167.1.1"}) {
    EXPECT_TRUE(is_public_v4(text)) << text;
  }
  for (const auto* text :
       {"0.0.0.0",        "10.0.0.1",        "100.64.0.1",      "100.127.255.255",
        "127.0.0.1",      "127.255.255.255", "169.254.169.254", "172.16.0.1",
        "172.31.255.255", "192.0.0.8",       "192.0.2.1",       "192.168.0.1",
        "198.18.0.1",     "198.19.255.255",  "198.51.100.1",    "203.0.113.1",
        "224.0.0.1",      "239.255.255.255", "240.0.0.1",       "255.255.255.255"}) {
    EXPECT_FALSE(is_public_v4(text)) << text;
  }
  for (const auto* text : {"2606:4700:4700::1111", "2a00:1450:4001::1", "2001:4860:4860::8888"}) {
    EXPECT_TRUE(is_public_v6(text)) << text;
  }
  for (const auto* text :
       {"::", "::1", "::ffff:127.0.0.1", "::ffff:8.8.8.8", "64:ff9b::7f00:1", "fe80::1", "fc00::1",
        "fdff::1", "ff02::1", "2001:db8::1", "2001::1", "2002:7f00:1::", "100::1", "fec0::1"}) {
    EXPECT_FALSE(is_public_v6(text)) << text;
  }
}

TEST(AllowedHosts, AreThoseOfTheListAtTheirPorts) {
  const AllowList list({"hooks.example", "Other.example:8080", "[::1]:9000"}, "--callback-allow");
  const auto may = [&](const char* uri) { return list.lets(target_of(uri, "")); };
  EXPECT_TRUE(may("http://hooks.example/a"));
  EXPECT_TRUE(may("https://HOOKS.example/a"));
  EXPECT_TRUE(may("http://other.example:8080/"));
  EXPECT_TRUE(may("http://[0:0::1]:9000/"));
  for (const auto* uri :
       {"http://hooks.example:81/", "https://hooks.example:80/", "http://other.example/",
        "http://a.hooks.example/", "http://hooks.example.evil/", "http://[::1]/"}) {
    EXPECT_FALSE(may(uri)) << uri;
  }
  EXPECT_FALSE(AllowList().lets(target_of("http://hooks.example/", "")));
  for (const std::string wrong :
       {"", "http://a", "a/b", "a:0x", "a:99999", "u@a", "*.a b", "::1"}) {
    EXPECT_THROW(AllowList({wrong}, "--callback-allow"), Error) << wrong;
  }
}

TEST(AllowedHosts, LeadToPublicAddressesOrThoseNamedThemselves) {
  const AllowList named({"hooks.example:9000", "localhost:9000", "127.0.0.1:9000"},
                        "--callback-allow");
  EXPECT_TRUE(lets(named, "http://hooks.example:9000/", "8.8.8.8"));
  EXPECT_FALSE(lets(named, "http://hooks.example:9000/", "10.0.0.1"));
  EXPECT_FALSE(lets(named, "http://hooks.example:9000/", "::1"));
  EXPECT_TRUE(lets(named, "http://127.0.0.1:9000/", "127.0.0.1"));
  EXPECT_TRUE(lets(named, "http://localhost:9000/", "127.0.0.1"));
  EXPECT_FALSE(lets(named, "http://localhost:9000/", "::1"));
  EXPECT_FALSE(lets(named, "http://127.0.0.1:9001/", "127.0.0.1"));
}

TEST(CallbackSignature, IsTheHmacOfTimeAndBody) {
  // openssl: printf '1700000000.{"a":1}' | openssl dgst -sha256 -hmac 0123456789abcdef
  EXPECT_EQ(http::signature_of("0123456789abcdef", "1700000000", R"({"a":1})"),
            "sha256=9eb18f493f8ec135d9eb2dad817c369bb4e9cbfa818657897a7437c1cd8c3a23");
}

TEST(CallbackSecret, IsALineOfSixteenCharactersAtLeast) {
  const TemporaryFolder folder;
  EXPECT_EQ(http::read_secret(folder.write("good", "0123456789abcdef\r\n")), "0123456789abcdef");
  EXPECT_THROW(http::read_secret(folder.write("short", "0123456789abcde\n")), Error);
  EXPECT_THROW(http::read_secret(folder.path / "none"), Error);
}

TEST(CallbackSender, AsksNobodyWhoIsNotOnItsListOrNotPublic) {
  const std::string secret(16, 's');
  const auto send = [&](const AllowList& list, const std::string& uri) {
    job::Delivery delivery;
    delivery.job = std::string(32, 'a');
    delivery.uri = uri;
    return http::Sender(list, secret)(delivery, {});
  };
  EXPECT_TRUE(send(AllowList({"a.example"}, "--callback-allow"), "http://b.example/").may_not);
  const auto inside = send(AllowList({"localhost:9"}, "--callback-allow"), "http://localhost:9/");
  EXPECT_TRUE(inside.may_not);
  EXPECT_NE(inside.why.find("not public"), std::string::npos) << inside.why;
  const auto nobody = send(AllowList({"127.0.0.1:9"}, "--callback-allow"), "http://127.0.0.1:9/");
  EXPECT_FALSE(nobody.may_not) << "it may be tried again";
  EXPECT_EQ(nobody.status, 0);
}

TEST(Courier, BringsWhatIsOwedUntilItIsTaken) {
  const TemporaryFolder folder;
  job::Settings settings;
  settings.data = folder.path / "data";
  settings.announce = [](const job::Job&, const std::filesystem::path&) { return "news"; };
  job::Queue queue(settings, engine_of([](const auto&) { return finished(); }));
  auto request = bake_of(good_scene());
  request.subscriber.success = "http://a/";
  std::atomic<int> tries = 0;
  const http::Courier courier(
      queue,
      [&](const job::Delivery& delivery, const std::stop_token&) -> http::Reply {
        EXPECT_EQ(delivery.body, "news");
        if (++tries == 1) return {0, false, "nobody listens"};
        return {tries == 2 ? 302 : 204, false, ""};
      },
      std::chrono::milliseconds(10));
  queue.submit(request);
  for (int i = 0; i < 1000 && queue.told().delivered == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(tries, 3);
  EXPECT_EQ(queue.told().delivered, 1U);
  EXPECT_EQ(queue.told().failed_tries, 2U);
  EXPECT_EQ(queue.told().pending, 0U);
}

}  // namespace
