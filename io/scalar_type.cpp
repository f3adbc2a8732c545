#include "io/scalar_type.h"

namespace backsight {

std::size_t SizeOf(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
    case ScalarType::kUint8:
      return 1;
    case ScalarType::kInt16:
    case ScalarType::kUint16:
      return 2;
    case ScalarType::kInt32:
    case ScalarType::kUint32:
    case ScalarType::kFloat32:
      return 4;
    case ScalarType::kInt64:
    case ScalarType::kUint64:
    case ScalarType::kFloat64:
      return 8;
  }
  return 0;
}

bool IsFloat(ScalarType type) {
  return type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
}

IntensityRange IntensityRangeOf(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
      return {-128.0, 127.0};
    case ScalarType::kUint8:
      return {0.0, 255.0};
    case ScalarType::kInt16:
      return {-32768.0, 32767.0};
    case ScalarType::kUint16:
    case ScalarType::kInt32:
    case ScalarType::kUint32:
    case ScalarType::kInt64:
    case ScalarType::kUint64:
      return {0.0, 65535.0};
    case ScalarType::kFloat32:
    case ScalarType::kFloat64:
      return {0.0, 1.0};
  }
  return {};
}

}  // namespace backsight
