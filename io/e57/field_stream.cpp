#include "io/e57/field_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <string_view>

#include "io/endian_bytes.h"

namespace backsight {
namespace {

// A load of 64 bits at the last byte of the content must stay within the buffer.
constexpr std::size_t kPadding = 8;

std::uint64_t LoadBits(const char* bytes, std::size_t position, unsigned bits) {
  const char* at = bytes + position / 8;
  const auto shift = static_cast<unsigned>(position % 8);
  std::uint64_t value = LoadBytes<std::uint64_t>(at) >> shift;
  if (shift + bits > 64) {
    value |= static_cast<std::uint64_t>(static_cast<unsigned char>(at[8])) << (64 - shift);
  }
  return bits == 64 ? value : value & ((std::uint64_t{1} << bits) - 1);
}

}  // namespace

void FieldStream::Refill() {
  if (!started_) next_packet_ = section_.begin();
  while (size_ - position_ < bits_) {
    const VectorSection::Packet* packet = section_.FindData(next_packet_);
    if (packet == nullptr) {
      throw section_.file().Error(
          started_ ? packet_ : section_.begin(),
          fmt::format("only {} values of field '{}' in the section", done_, field_.name),
          fmt::format("{}, one per record", section_.record_count()));
    }
    next_packet_ = packet->end;
    packet_ = packet->offset;
    const std::size_t left = size_ - position_;
    if (started_ && packet->restart && left >= 8) {
      throw section_.file().Error(
          packet_, fmt::format("a restart with {} bits of field '{}' left over", left, field_.name),
          "fewer than 8 bits, which fill up the last byte");
    }
    // What is left is less than one value: less than 9 bytes, with the part of its first byte.
    const std::size_t used = packet->restart ? size_ / 8 : position_ / 8;
    const auto begin = buffer_.begin() + static_cast<std::ptrdiff_t>(used);
    const auto end = buffer_.begin() + static_cast<std::ptrdiff_t>(size_ / 8);
    std::copy(begin, end, buffer_.begin());
    const std::size_t kept = size_ / 8 - used;
    position_ = packet->restart ? 0 : position_ % 8;
    const std::string_view more = packet->Bytes(stream_);
    buffer_.resize(kept + more.size() + kPadding);
    std::copy(more.begin(), more.end(), buffer_.begin() + static_cast<std::ptrdiff_t>(kept));
    size_ = (kept + more.size()) * 8;
    started_ = true;
  }
}

std::uint64_t FieldStream::NextBits() {
  if (size_ - position_ < bits_) Refill();
  const std::uint64_t value = LoadBits(buffer_.data(), position_, bits_);
  position_ += bits_;
  ++done_;
  return value;
}

std::int64_t FieldStream::NextInteger() {
  if (bits_ == 0) return field_.minimum;
  const std::uint64_t above = NextBits();
  if (above > field_.Span()) {
    throw section_.file().Error(
        packet_,
        fmt::format("a value of field '{}' that is {} above its minimum", field_.name, above),
        fmt::format("{} to {}", field_.minimum, field_.maximum));
  }
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(field_.minimum) + above);
}

void FieldStream::Read(std::span<std::int64_t> values) {
  for (std::int64_t& value : values) value = NextInteger();
}

void FieldStream::Read(std::span<double> values) {
  if (field_.IsInteger()) {
    for (double& value : values) value = field_.Value(NextInteger());
  } else if (field_.type == E57Type::kSingle) {
    for (double& value : values) {
      value = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(NextBits())));
    }
  } else {
    for (double& value : values) value = std::bit_cast<double>(NextBits());
  }
}

}  // namespace backsight
