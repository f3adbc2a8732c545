#pragma once

#include <array>
#include <bit>
#include <string>

#include "io/endian_bytes.h"

namespace backsight {

/// Appends the bytes of `value` in byte order `order`.
template <Arithmetic T>
void Append(std::string& bytes, T value, std::endian order = std::endian::little) {
  std::array<char, sizeof(T)> raw{};
  StoreBytes(raw.data(), value, order);
  bytes.append(raw.data(), raw.size());
}

}  // namespace backsight
