#include "io/e57/crc32c.h"

#include <isa-l/crc.h>

#include <limits>

#include "core/error.h"

namespace backsight {

std::uint32_t Crc32c(std::string_view bytes) {
  BACKSIGHT_CHECK(bytes.size() <= std::numeric_limits<int>::max(), "too long for one checksum");
  // ISA-L leaves both inversions of the definition to its caller. It takes a plain pointer but
  // only reads.
  auto* data = reinterpret_cast<unsigned char*>(const_cast<char*>(bytes.data()));
  return ~::crc32_iscsi(data, static_cast<int>(bytes.size()), 0xFFFFFFFFU);
}

}  // namespace backsight
