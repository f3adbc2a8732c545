#include "io/lzf.h"

#include <algorithm>

namespace backsight {

bool DecodeLzf(std::span<const char> packed, std::span<char> unpacked) {
  const auto byte_at = [&](std::size_t i) {
    return static_cast<std::size_t>(static_cast<unsigned char>(packed[i]));
  };
  std::size_t in = 0;
  std::size_t out = 0;
  while (in < packed.size()) {
    const std::size_t control = byte_at(in++);
    if (control < 32) {
      const std::size_t length = control + 1;
      if (packed.size() - in < length || unpacked.size() - out < length) return false;
      std::copy_n(packed.data() + in, length, unpacked.data() + out);
      in += length;
      out += length;
      continue;
    }
    std::size_t length = (control >> 5U) + 2;
    if (control >> 5U == 7) {
      if (in == packed.size()) return false;
      length += byte_at(in++);
    }
    if (in == packed.size()) return false;
    const std::size_t distance = ((control & 31U) << 8U) + byte_at(in++) + 1;
    if (distance > out || unpacked.size() - out < length) return false;
    // One by one, because the copy may overlap its own output (that is how runs are coded).
    for (const std::size_t end = out + length; out != end; ++out) {
      unpacked[out] = unpacked[out - distance];
    }
  }
  return out == unpacked.size();
}

}  // namespace backsight
