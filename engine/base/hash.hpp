#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace hoodoo {

/// A SHA-256 digest: the name of a content everywhere in hoodoo.
struct Digest {
  std::array<std::uint8_t, 32> bytes{};
  std::string hex() const;  // 64 lower-case digits
  static std::optional<Digest> parse(std::string_view hex);
  /// Its first eight bytes, which tell apart all digests that one machine will ever hold.
  std::uint64_t start() const;
  friend auto operator<=>(const Digest&, const Digest&) = default;
};

/// SHA-256 of bytes fed piece by piece. FIPS 180-4, by OpenSSL.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;
  void add(std::span<const std::byte> bytes);
  void add(std::string_view text);
  Digest finish();

 private:
  void* context_;
};

Digest sha256(std::span<const std::byte> bytes);
Digest sha256(std::string_view text);

}  // namespace hoodoo
