#pragma once

#include <array>
#include <cstdint>

namespace backsight {

/// Places on a lattice of 2^16 along each axis as one number, the bits of x, y and z in turn with
/// those of x lowest (Morton order): what lies in one octant of an octree lies in one run.
struct Morton {
  static constexpr int kBits = 16;                           // per axis
  static constexpr std::uint64_t kAxis = 0x249249249249ULL;  // the bits of x

  static constexpr std::uint64_t Of(const std::array<std::uint16_t, 3>& place) {
    return Spread(place[0]) | Spread(place[1]) << 1U | Spread(place[2]) << 2U;
  }
  static constexpr std::array<std::uint16_t, 3> Place(std::uint64_t code) {
    return {Gather(code), Gather(code >> 1U), Gather(code >> 2U)};
  }

 private:
  static constexpr std::uint64_t Spread(std::uint64_t bits) {
    bits = (bits | bits << 16U) & 0x0000FF0000FFULL;
    bits = (bits | bits << 8U) & 0x00F00F00F00FULL;
    bits = (bits | bits << 4U) & 0x0C30C30C30C3ULL;
    return (bits | bits << 2U) & kAxis;
  }
  static constexpr std::uint16_t Gather(std::uint64_t bits) {
    bits &= kAxis;
    bits = (bits | bits >> 2U) & 0x0C30C30C30C3ULL;
    bits = (bits | bits >> 4U) & 0x00F00F00F00FULL;
    bits = (bits | bits >> 8U) & 0x0000FF0000FFULL;
    return static_cast<std::uint16_t>(bits | bits >> 16U);
  }
};

}  // namespace backsight
