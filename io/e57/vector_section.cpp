#include "io/e57/vector_section.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/endian_bytes.h"

namespace backsight {
namespace {

constexpr std::size_t kSectionHeaderBytes = 32;
constexpr std::size_t kPacketHeaderBytes = 4;
constexpr std::uint8_t kSectionId = 1;
// Records of no bits at all cost the file nothing; a legitimate file has a handful of them.
constexpr std::uint64_t kMaxBitlessRecords = 65536;

enum PacketType : std::uint8_t { kIndexPacket = 0, kDataPacket = 1, kIgnoredPacket = 2 };

}  // namespace

VectorSection::VectorSection(PagedFile& file, const E57VectorPlace& place,
                             const std::vector<E57Field>& fields)
    : file_(file), place_(place), field_count_(fields.size()) {
  // Some software writes no valid section for no records.
  if (place.record_count == 0) return;
  start_ = file.Logical(place.file_offset, place.stated_at, "a section of points");
  std::array<char, kSectionHeaderBytes> header{};
  file.Read(start_, header.data(), header.size(), "bytes of a section header");
  const auto id = LoadBytes<std::uint8_t>(header.data());
  if (id != kSectionId) {
    throw file.Error(start_, fmt::format("a section of kind {}", id), "kind 1, compressed vector");
  }
  const auto bytes = LoadBytes<std::uint64_t>(&header[8]);
  if (bytes < kSectionHeaderBytes || bytes > file.size() - start_) {
    throw file.Error(start_ + 8, fmt::format("a section of {} bytes", bytes),
                     fmt::format("32 to {} bytes", file.size() - start_));
  }
  end_ = start_ + bytes;
  begin_ = file.Logical(LoadBytes<std::uint64_t>(&header[16]), start_ + 16, "the first packet");
  if (begin_ < start_ + kSectionHeaderBytes || begin_ > end_) {
    throw file.Error(
        start_ + 16, "a first packet outside of its section",
        fmt::format("a packet from byte {} on", E57Physical(start_ + kSectionHeaderBytes)));
  }
  CheckCapacity(fields);
}

void VectorSection::CheckCapacity(const std::vector<E57Field>& fields) const {
  std::uint64_t most = kMaxBitlessRecords;
  bool bounded = false;
  for (const E57Field& field : fields) {
    if (field.Bits() == 0) continue;
    const std::uint64_t room = (end_ - begin_) * 8 / field.Bits();
    most = bounded ? std::min(most, room) : room;
    bounded = true;
  }
  if (place_.record_count <= most) return;
  throw file_.Error(place_.stated_at, fmt::format("{} records", place_.record_count),
                    fmt::format("at most {} records, which the section has room for", most));
}

const VectorSection::Packet* VectorSection::FindData(std::uint64_t offset) {
  for (const Packet& packet : packets_) {
    if (packet.sought == offset) return &packet;
  }
  Packet& packet = packets_[oldest_];
  packet.sought = UINT64_MAX;  // stays so if reading fails
  for (std::uint64_t at = offset; at < end_; at = packet.end) {
    if (!Load(at, packet)) continue;
    packet.sought = offset;
    oldest_ = (oldest_ + 1) % packets_.size();
    return &packet;
  }
  return nullptr;
}

/// Reads the packet at `offset`; false if it is no data packet.
bool VectorSection::Load(std::uint64_t offset, Packet& packet) {
  std::array<char, kPacketHeaderBytes> header{};
  if (end_ - offset < header.size()) {
    throw file_.Error(offset, fmt::format("{} bytes", end_ - offset), "a packet");
  }
  file_.Read(offset, header.data(), header.size(), "bytes of a packet header");
  const auto type = LoadBytes<std::uint8_t>(header.data());
  const std::uint64_t bytes = LoadBytes<std::uint16_t>(&header[2]) + std::uint64_t{1};
  if (type > kIgnoredPacket) {
    throw file_.Error(offset, fmt::format("a packet of kind {}", type),
                      "kind 0 (index), 1 (data) or 2 (ignored)");
  }
  if (bytes % 4 != 0 || bytes > end_ - offset) {
    throw file_.Error(offset + 2, fmt::format("a packet of {} bytes", bytes),
                      fmt::format("a multiple of 4, at most {}", end_ - offset));
  }
  packet.offset = offset;
  packet.end = offset + bytes;
  if (type != kDataPacket) return false;
  packet.restart = (LoadBytes<std::uint8_t>(&header[1]) & 1U) != 0;
  LoadStreams(bytes, packet);
  return true;
}

void VectorSection::LoadStreams(std::uint64_t bytes, Packet& packet) {
  const std::uint64_t table = kPacketHeaderBytes + 2;
  packet.bytes.resize(static_cast<std::size_t>(bytes));
  file_.Read(packet.offset, packet.bytes.data(), packet.bytes.size(), "bytes of a packet");
  const std::size_t count =
      bytes < table ? 0 : LoadBytes<std::uint16_t>(&packet.bytes[kPacketHeaderBytes]);
  if (count != field_count_ || bytes < table + 2 * count) {
    throw file_.Error(packet.offset, fmt::format("a packet of {} bytestreams", count),
                      fmt::format("{} bytestreams, one per field of a record", field_count_));
  }
  packet.streams.resize(count);
  std::size_t begin = static_cast<std::size_t>(table) + 2 * count;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t size = LoadBytes<std::uint16_t>(&packet.bytes[table + 2 * i]);
    if (size > packet.bytes.size() - begin) {
      throw file_.Error(
          packet.offset + table + 2 * i, fmt::format("a bytestream of {} bytes", size),
          fmt::format("at most {}, to the packet's end", packet.bytes.size() - begin));
    }
    packet.streams[i] = {begin, size};
    begin += size;
  }
}

}  // namespace backsight
