#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace backsight {

/// CRC-32C by a table of its own, independent of the one under test.
std::uint32_t TableCrc32c(std::string_view bytes);

/// Cuts a payload into pages with checksums; the last page is filled up with zeros.
std::string Paged(std::string_view payload);

/// The payload of all whole pages; checksums are dropped unseen.
std::string Payload(std::string_view paged);

/// Values of `bits` bits each, least significant bit first, filled up to a whole byte.
std::string PackBits(std::span<const std::uint64_t> values, unsigned bits);

/// Values as their little-endian bytes.
template <typename T>
std::string PackNumbers(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  for (std::size_t i = 0; i < values.size(); ++i) {
    __builtin_memcpy(&bytes[i * sizeof(T)], &values[i], sizeof(T));
  }
  return bytes;
}

/// A data packet of these bytestreams.
std::string DataPacket(const std::vector<std::string>& streams, std::uint8_t flags = 0);

/// What the XML of a test file says of one scan, beside its points.
struct TestScan {
  std::string before_points;  ///< XML elements
  std::string prototype;      ///< XML elements
  std::uint64_t records = 0;
  std::vector<std::string> packets;
};

/// The payload of an E57 file with these scans, assembled by the book and without the writer.
std::string E57Payload(const std::vector<TestScan>& scans);

/// Two scans of three packets each, with fields of every type.
std::string RichE57Payload();

/// The payload of a file that is one section of `packets` and the given XML; "@" stands for the
/// section's offset.
std::string E57PayloadOf(const std::vector<std::string>& packets, std::string xml);

/// XML text around the elements of e57Root.
std::string RootXml(std::string_view elements);

}  // namespace backsight
