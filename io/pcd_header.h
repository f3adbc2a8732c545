#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/rigid_transform.h"
#include "io/line_reader.h"
#include "io/scalar_type.h"

namespace backsight {

struct PcdField {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::size_t count = 1;   ///< values per record
  std::size_t offset = 0;  ///< bytes from the start of the record
  std::size_t column = 0;  ///< first text column of an ascii record
};

enum class PcdData { kAscii, kBinary, kCompressed };

/// Header of a PCD file, versions 0.5 to 0.7.
struct PcdHeader {
  std::vector<PcdField> fields;
  std::size_t record_bytes = 0;  ///< 1 to 65536
  std::size_t columns = 0;       ///< values per record
  std::uint64_t points = 0;
  std::uint64_t width = 0;
  std::uint64_t height = 1;
  PcdData data = PcdData::kAscii;
  std::optional<RigidTransform> viewpoint;  ///< as the file states it, where it is a pose
  bool viewpoint_unusable = false;          ///< stated, but no finite pose with a unit quaternion

  /// The field of this name that has one value per record, or null.
  const PcdField* Find(std::string_view name) const;
};

/// Reads up to and including the DATA line. Throws InputError with the line.
PcdHeader ReadPcdHeader(LineReader& lines);

}  // namespace backsight
