#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "io/endian_bytes.h"
#include "io/point_collector.h"

namespace backsight {

/// Number types of the fields of binary point records.
enum class ScalarType {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64
};

/// Bytes of one value.
std::size_t SizeOf(ScalarType type);

bool IsFloat(ScalarType type);

/// The raw values that stand for dark and bright where intensity is stored as `type`: the type's
/// own range for 8 and 16 bit integers, 0 to 65535 for longer ones, 0 to 1 for floating point.
IntensityRange IntensityRangeOf(ScalarType type);

/// Reads one value; integers beyond 2^53 are rounded.
inline double LoadScalar(const char* bytes, ScalarType type, std::endian order) {
  switch (type) {
    case ScalarType::kInt8:
      return LoadBytes<std::int8_t>(bytes, order);
    case ScalarType::kUint8:
      return LoadBytes<std::uint8_t>(bytes, order);
    case ScalarType::kInt16:
      return LoadBytes<std::int16_t>(bytes, order);
    case ScalarType::kUint16:
      return LoadBytes<std::uint16_t>(bytes, order);
    case ScalarType::kInt32:
      return LoadBytes<std::int32_t>(bytes, order);
    case ScalarType::kUint32:
      return LoadBytes<std::uint32_t>(bytes, order);
    case ScalarType::kInt64:
      return static_cast<double>(LoadBytes<std::int64_t>(bytes, order));
    case ScalarType::kUint64:
      return static_cast<double>(LoadBytes<std::uint64_t>(bytes, order));
    case ScalarType::kFloat32:
      return static_cast<double>(LoadBytes<float>(bytes, order));
    case ScalarType::kFloat64:
      return LoadBytes<double>(bytes, order);
  }
  return 0.0;
}

}  // namespace backsight
