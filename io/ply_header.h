#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "io/line_reader.h"
#include "io/scalar_type.h"

namespace backsight {

struct PlyProperty {
  std::string name;
  ScalarType type = ScalarType::kFloat32;  ///< of the value, or of each list entry
  bool is_list = false;
  ScalarType count_type = ScalarType::kUint8;  ///< of the number of list entries
  std::size_t offset = 0;                      ///< in the record; only where it has no list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  bool has_list = false;
  std::size_t record_bytes = 0;  ///< 0 to 65536; only where has_list is false
};

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;  ///< in the order of the file
};

/// Reads up to and including end_header. Throws InputError with the line.
PlyHeader ReadPlyHeader(LineReader& lines);

}  // namespace backsight
