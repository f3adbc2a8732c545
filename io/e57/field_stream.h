#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/e57/vector_section.h"

namespace backsight {

/// Decodes the values of one field, record after record, wherever the packets hold them: integers
/// packed least significant bit first as difference to the field's minimum, floats and doubles as
/// little-endian IEEE 754 (ASTM E2807, clause 9.3). All functions throw InputError if the section
/// ends before the wanted values, or for an integer beyond the field's bounds. Memory: one packet.
class FieldStream {
 public:
  /// `field` is number `stream` of the section's fields; no string. Keeps references to both.
  FieldStream(VectorSection& section, const E57Field& field, std::size_t stream)
      : section_(section), field_(field), stream_(stream), bits_(field.Bits()) {}

  const E57Field& field() const { return field_; }

  /// The next stored integers; only for integer types.
  void Read(std::span<std::int64_t> values);
  /// The next values as numbers; integers beyond 2^53 are rounded.
  void Read(std::span<double> values);

 private:
  /// Brings the bits of the next value into the buffer.
  void Refill();
  std::uint64_t NextBits();
  std::int64_t NextInteger();

  VectorSection& section_;
  const E57Field& field_;
  std::size_t stream_;
  unsigned bits_;
  bool started_ = false;           // a packet was fetched
  std::uint64_t next_packet_ = 0;  // logical offset
  std::uint64_t packet_ = 0;       // logical offset of the packet fetched last, for errors
  std::uint64_t done_ = 0;         // values decoded
  std::vector<char> buffer_;       // 8 bytes longer than its content
  std::size_t position_ = 0;       // of the next value, in bits
  std::size_t size_ = 0;           // in bits
};

}  // namespace backsight
