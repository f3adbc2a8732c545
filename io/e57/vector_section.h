#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "io/e57/e57_field.h"
#include "io/e57/paged_file.h"

namespace backsight {

/// Where XML says that a compressed vector lies.
struct E57VectorPlace {
  std::uint64_t file_offset = 0;   ///< physical offset of the section
  std::uint64_t record_count = 0;  ///< records in the section
  std::uint64_t stated_at = 0;     ///< logical offset of the statement, for errors
};

/// The packets of one compressed vector section (ASTM E2807, clause 9.3). Holds the last few
/// packets, because the bytestreams of a record may lie in neighbouring packets. Memory: 4 packets
/// of up to 64 KB.
class VectorSection {
 public:
  struct Stream {
    std::size_t begin = 0;  ///< in Packet::bytes
    std::size_t size = 0;
  };
  struct Packet {
    std::uint64_t sought = UINT64_MAX;  ///< where it was looked for; other packets may lie between
    std::uint64_t offset = 0;           ///< logical
    std::uint64_t end = 0;
    bool restart = false;  ///< its bytestreams do not go on with bits of packets before
    std::vector<char> bytes;
    std::vector<Stream> streams;  ///< one per field

    std::string_view Bytes(std::size_t stream) const {
      return {bytes.data() + streams[stream].begin, streams[stream].size};
    }
  };

  /// Reads the section's header. Throws InputError if the section is too short for its records.
  VectorSection(PagedFile& file, const E57VectorPlace& place, const std::vector<E57Field>& fields);

  /// Logical offset of the first packet.
  std::uint64_t begin() const { return begin_; }
  std::uint64_t record_count() const { return place_.record_count; }
  const PagedFile& file() const { return file_; }

  /// The first data packet at or behind logical offset `offset`, or null behind the last one. It
  /// stays valid until the next call.
  const Packet* FindData(std::uint64_t offset);

 private:
  void CheckCapacity(const std::vector<E57Field>& fields) const;
  bool Load(std::uint64_t offset, Packet& packet);
  void LoadStreams(std::uint64_t bytes, Packet& packet);

  PagedFile& file_;
  E57VectorPlace place_;
  std::size_t field_count_;
  std::uint64_t start_ = 0;  // of the section's header
  std::uint64_t begin_ = 0;
  std::uint64_t end_ = 0;
  std::array<Packet, 4> packets_;
  std::size_t oldest_ = 0;
};

}  // namespace backsight
