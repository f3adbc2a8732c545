#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace backsight {

/// Where a packed key belongs in a hash table of `mask` + 1 places, a power of two up to 2^63: the
/// highest bits of two multiplications (Fibonacci hashing: Knuth, The Art of Computer Programming
/// 3, section 6.4). One would leave lines or walls along some axis close together.
inline std::size_t KeySlot(std::uint64_t key, std::size_t mask) {
  constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15U;
  const std::uint64_t once = key * kGolden;
  const std::uint64_t twice = (once ^ (once >> 32U)) * kGolden;
  // In two steps, since a table of one place takes no bits.
  return static_cast<std::size_t>(twice >> 1U >> (63 - std::popcount(mask)));
}

}  // namespace backsight
