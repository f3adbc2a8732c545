#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace backsight {

/// Where a packed key belongs in a hash table of `mask` + 1 places, a power of two up to 2^63:
/// Fibonacci hashing (Knuth, The Art of Computer Programming 3, section 6.4), the highest bits of
/// the product, which alone depend on all bits of the key.
inline std::size_t KeySlot(std::uint64_t key, std::size_t mask) {
  // In two steps, since a table of one place takes no bits.
  return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15U) >> 1U >> (63 - std::popcount(mask)));
}

}  // namespace backsight
