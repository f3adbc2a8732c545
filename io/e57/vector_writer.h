#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "io/e57/e57_field.h"
#include "io/e57/paged_writer.h"

namespace backsight {

/// Writes one compressed vector section (ASTM E2807, clause 9.3): data packets of up to 64 KB, in
/// which every bytestream holds the same records, and one index packet for the first of them, which
/// is all that the standard demands. For every record one Put per field, in the order of the
/// fields, then EndRecord. Memory: one packet.
class VectorWriter {
 public:
  /// Begins the section at the writer's position. No field may be a string.
  VectorWriter(PagedWriter& out, std::vector<E57Field> fields);

  /// Physical offset of the section.
  std::uint64_t file_offset() const { return E57Physical(start_); }
  const std::vector<E57Field>& fields() const { return fields_; }

  /// A stored integer within the bounds of integer field `field`.
  void Put(std::size_t field, std::int64_t value);
  /// A value of a float field; rounded where it is single.
  void Put(std::size_t field, double value);
  void EndRecord();
  /// Ends the section; returns the number of records.
  std::uint64_t Finish();

 private:
  struct Stream {
    std::string bytes;
    std::uint64_t pending = 0;  // bits that are not yet in `bytes`, the first one lowest
    unsigned pending_bits = 0;

    void Put(std::uint64_t value, unsigned bits);
    void Flush();
  };

  void WritePacket();
  void WriteIndex();

  PagedWriter& out_;
  std::vector<E57Field> fields_;
  std::vector<Stream> streams_;
  std::uint64_t start_;
  std::uint64_t packet_records_;
  std::uint64_t in_packet_ = 0;
  std::uint64_t records_ = 0;
  std::uint64_t packets_ = 0;
};

}  // namespace backsight
