#include "engine/base/hash.hpp"

#include <gtest/gtest.h>

#include <string>

using namespace hoodoo;

// FIPS 180-4 example values, as NIST's "SHA256" example computations print them.
TEST(Sha256, GivesTheDigestsOfTheStandard) {
  EXPECT_EQ(sha256("").hex(), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc").hex(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq").hex(),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, DoesNotDependOnHowTheBytesArrive) {
  const std::string text(1000, 'a');
  Sha256 pieces;
  for (std::size_t i = 0; i < text.size(); i += 7) pieces.add(text.substr(i, 7));
  EXPECT_EQ(pieces.finish(), sha256(text));
}

TEST(Digest, ReadsWhatItWritesAndNothingElse) {
  const Digest digest = sha256("abc");
  EXPECT_EQ(Digest::parse(digest.hex()), digest);
  EXPECT_EQ(digest.start(), 0xba7816bf8f01cfeaU);
  for (std::string bad : {std::string(), digest.hex().substr(1), digest.hex() + "0",
                          "B" + digest.hex().substr(1), "g" + digest.hex().substr(1)}) {
    EXPECT_EQ(Digest::parse(bad), std::nullopt) << bad;
  }
}
