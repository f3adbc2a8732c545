#pragma once

#include <cstddef>
#include <cstdint>

namespace backsight {

/// Where a packed key belongs in a hash table of `mask` + 1 places, a power of two up to 2^32:
/// Fibonacci hashing (Knuth, The Art of Computer Programming 3, section 6.4) by the upper half of
/// the product, whose low bits are poor.
inline std::size_t KeySlot(std::uint64_t key, std::size_t mask) {
  return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15U) >> 32U) & mask;
}

}  // namespace backsight
