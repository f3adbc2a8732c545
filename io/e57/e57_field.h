#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <string>

namespace backsight {

/// Smallest and largest value of a quantity.
struct E57Limits {
  double low = 0.0;
  double high = 0.0;
};

enum class E57Type { kInteger, kScaledInteger, kSingle, kDouble, kString };

/// One field of the records of a compressed vector: a leaf of its prototype (ASTM E2807, clause
/// 8.3). Each field is stored as a bytestream of its own, in the order of the prototype.
struct E57Field {
  std::string name;  ///< empty for a field within a structure, which no standard field is
  E57Type type = E57Type::kDouble;
  /// Bounds of the stored integer, for integer types.
  std::int64_t minimum = std::numeric_limits<std::int64_t>::min();
  std::int64_t maximum = std::numeric_limits<std::int64_t>::max();
  /// A scaled integer n stands for n * scale + offset.
  double scale = 1.0;
  double offset = 0.0;
  /// Bounds of the value; low > high where a float states none.
  E57Limits limits{1.0, 0.0};

  bool IsInteger() const { return type == E57Type::kInteger || type == E57Type::kScaledInteger; }

  /// maximum - minimum; does not overflow.
  std::uint64_t Span() const {
    return static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(minimum);
  }

  /// Bits of one value. An integer takes what its bounds need: none if they are equal. A string
  /// takes at least the 8 bits of its length.
  unsigned Bits() const {
    if (IsInteger()) return static_cast<unsigned>(std::bit_width(Span()));
    if (type == E57Type::kString) return 8;
    return type == E57Type::kSingle ? 32 : 64;
  }

  /// What the stored integer stands for.
  double Value(std::int64_t stored) const {
    const auto number = static_cast<double>(stored);
    return type == E57Type::kScaledInteger ? number * scale + offset : number;
  }
};

}  // namespace backsight
