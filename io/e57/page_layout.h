#pragma once

#include <cstddef>
#include <cstdint>

namespace backsight {

/// An E57 file is a sequence of pages of 1024 bytes: 1020 bytes of payload and the CRC-32C of
/// these, most significant byte first (ASTM E2807, clause 9). "Physical" offsets count all bytes of
/// the file; "logical" offsets count payload only.
inline constexpr std::uint64_t kE57PageBytes = 1024;
inline constexpr std::uint64_t kE57PayloadBytes = 1020;
/// Bytes of the file header, which begins the first page.
inline constexpr std::size_t kE57HeaderBytes = 48;

constexpr std::uint64_t E57Physical(std::uint64_t logical) {
  return logical / kE57PayloadBytes * kE57PageBytes + logical % kE57PayloadBytes;
}

/// Only for physical offsets of payload, not of checksums.
constexpr std::uint64_t E57Logical(std::uint64_t physical) {
  return physical / kE57PageBytes * kE57PayloadBytes + physical % kE57PageBytes;
}

}  // namespace backsight
