#pragma once

#include <cstdint>
#include <string_view>

namespace backsight {

/// CRC-32C (Castagnoli polynomial, reflected, all ones before and after) of `bytes`, as RFC 3720
/// and the pages of E57 files use it: "123456789" gives 0xE3069283. At most 2 GB at a time.
std::uint32_t Crc32c(std::string_view bytes);

}  // namespace backsight
