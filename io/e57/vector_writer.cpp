#include "io/e57/vector_writer.h"

#include <array>
#include <bit>

#include "core/error.h"
#include "io/endian_bytes.h"

namespace backsight {
namespace {

constexpr std::size_t kSectionHeaderBytes = 32;
constexpr std::size_t kIndexPacketBytes = 32;
constexpr std::uint64_t kPacketBytes = 65536;

/// As many records as fit into a packet. A multiple of 8, so that every bytestream ends with a
/// whole byte and goes on in the next packet without one bit between, restart or not.
std::uint64_t RecordsPerPacket(const std::vector<E57Field>& fields) {
  std::uint64_t bits = 0;
  for (const E57Field& field : fields) {
    BACKSIGHT_CHECK(field.type != E57Type::kString, "strings cannot be written");
    bits += field.Bits();
  }
  if (bits == 0) return kPacketBytes;
  const std::uint64_t head = 6 + 2 * fields.size();
  BACKSIGHT_CHECK(head + 3 + bits <= kPacketBytes, "too many fields for a packet");
  return (kPacketBytes - head - 3) * 8 / bits / 8 * 8;
}

}  // namespace

void VectorWriter::Stream::Put(std::uint64_t value, unsigned bits) {
  pending |= value << pending_bits;
  if (pending_bits + bits < 64) {
    pending_bits += bits;
    return;
  }
  std::array<char, 8> word{};
  StoreBytes(word.data(), pending);
  bytes.append(word.data(), word.size());
  pending = pending_bits == 0 ? 0 : value >> (64 - pending_bits);
  pending_bits = pending_bits + bits - 64;
}

void VectorWriter::Stream::Flush() {
  std::array<char, 8> word{};
  StoreBytes(word.data(), pending);
  bytes.append(word.data(), (pending_bits + 7) / 8);
  pending = 0;
  pending_bits = 0;
}

VectorWriter::VectorWriter(PagedWriter& out, std::vector<E57Field> fields)
    : out_(out), fields_(std::move(fields)), streams_(fields_.size()) {
  out_.Align();
  start_ = out_.Reserve(kSectionHeaderBytes);
  packet_records_ = RecordsPerPacket(fields_);
}

void VectorWriter::Put(std::size_t field, std::int64_t value) {
  const E57Field& to = fields_[field];
  BACKSIGHT_CHECK(to.IsInteger() && value >= to.minimum && value <= to.maximum,
                  "an integer beyond the bounds of its field");
  streams_[field].Put(static_cast<std::uint64_t>(value) - static_cast<std::uint64_t>(to.minimum),
                      to.Bits());
}

void VectorWriter::Put(std::size_t field, double value) {
  const E57Field& to = fields_[field];
  BACKSIGHT_CHECK(!to.IsInteger(), "a float for an integer field");
  if (to.type == E57Type::kSingle) {
    streams_[field].Put(std::bit_cast<std::uint32_t>(static_cast<float>(value)), 32);
  } else {
    streams_[field].Put(std::bit_cast<std::uint64_t>(value), 64);
  }
}

void VectorWriter::EndRecord() {
  ++records_;
  if (++in_packet_ == packet_records_) WritePacket();
}

void VectorWriter::WritePacket() {
  std::string packet(6 + 2 * streams_.size(), '\0');
  packet[0] = 1;
  StoreBytes(&packet[4], static_cast<std::uint16_t>(streams_.size()));
  for (std::size_t i = 0; i < streams_.size(); ++i) {
    streams_[i].Flush();
    StoreBytes(&packet[6 + 2 * i], static_cast<std::uint16_t>(streams_[i].bytes.size()));
    packet += streams_[i].bytes;
    streams_[i].bytes.clear();
  }
  packet.resize((packet.size() + 3) / 4 * 4, '\0');
  StoreBytes(&packet[2], static_cast<std::uint16_t>(packet.size() - 1));
  out_.Write(packet);
  in_packet_ = 0;
  ++packets_;
}

void VectorWriter::WriteIndex() {
  std::array<char, kIndexPacketBytes> packet{};
  StoreBytes(&packet[2], static_cast<std::uint16_t>(packet.size() - 1));
  StoreBytes(&packet[4], std::uint16_t{1});
  StoreBytes(&packet[24], E57Physical(start_ + kSectionHeaderBytes));
  out_.Write({packet.data(), packet.size()});
}

std::uint64_t VectorWriter::Finish() {
  // Even a section of no records has a data packet (clause 9.3.5).
  if (in_packet_ > 0 || packets_ == 0) WritePacket();
  const std::uint64_t index = out_.position();
  WriteIndex();
  std::array<char, kSectionHeaderBytes> header{};
  header[0] = 1;
  StoreBytes(&header[8], out_.position() - start_);
  StoreBytes(&header[16], E57Physical(start_ + kSectionHeaderBytes));
  StoreBytes(&header[24], E57Physical(index));
  out_.Fill(start_, {header.data(), header.size()});
  return records_;
}

}  // namespace backsight
