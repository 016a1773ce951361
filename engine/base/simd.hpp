#pragma once
#include <string>
#include <string_view>

namespace hoodoo {

/// Holds run-time dispatch to an instruction set: "ssse3", "sse4", "avx2", or "best". For
/// tests and for telling a processor's fault from ours: results are the same bits on all of them.
/// Call it before any other thread starts. Errors: bad_input naming `where`.
void limit_simd(std::string_view name, std::string_view where);

/// The instruction set in use, by Highway's name.
std::string simd_target();

}  // namespace hoodoo
