#pragma once

#include <cstddef>
#include <span>

namespace backsight {

/// No LZF stream of n bytes unpacks to more than n * kLzfMaxRatio: a back reference of three bytes
/// copies at most 264.
inline constexpr std::size_t kLzfMaxRatio = 88;

/// Unpacks an LZF stream, the compression of PCD's binary_compressed. A control byte below 32
/// announces control + 1 literal bytes; otherwise its upper three bits are the length of a copy
/// from earlier output, minus 2 (7: the next byte adds to it), its lower five bits and one more
/// byte the distance back, minus 1. Returns false unless `packed` is well-formed and fills
/// `unpacked` exactly.
bool DecodeLzf(std::span<const char> packed, std::span<char> unpacked);

}  // namespace backsight
