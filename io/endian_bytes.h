#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>

namespace backsight {

template <typename T>
concept Arithmetic = std::integral<T> || std::floating_point<T>;

/// Reads a T from `sizeof(T)` bytes stored in byte order `order`; no alignment needed.
template <Arithmetic T>
T LoadBytes(const char* bytes, std::endian order = std::endian::little) {
  std::array<char, sizeof(T)> raw{};
  std::copy_n(bytes, sizeof(T), raw.begin());
  if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

/// Writes `value` as `sizeof(T)` bytes in byte order `order`.
template <Arithmetic T>
void StoreBytes(char* bytes, T value, std::endian order = std::endian::little) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
  std::copy_n(raw.begin(), sizeof(T), bytes);
}

}  // namespace backsight
