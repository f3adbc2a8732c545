#include <cstdint>

#include "io/pcd_reader.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/io/append_bytes.h"

namespace backsight {
namespace {

constexpr const char* kXyz = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
constexpr const char* kRich =
    "FIELDS normal x y z rgb intensity\nSIZE 4 8 8 8 4 2\nTYPE F F F I F U\nCOUNT 3 1 1 1 1 1\n";
constexpr std::string_view kCompressed = "DATA binary_compressed\n";

std::string Header(const std::string& fields, const std::string& size, const std::string& data) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n" + fields + size + "DATA " +
         data + "\n";
}

std::string RichRecords(int count) {
  std::string bytes;
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) Append(bytes, 0.5F);
    Append(bytes, 1.5 * i), Append(bytes, -2.0), Append(bytes, std::int64_t{i - 1});
    Append(bytes, std::uint32_t{0x00102030}), Append(bytes, static_cast<std::uint16_t>(9000 * i));
  }
  return bytes;
}

/// Twelve points whose coordinates are all the same byte: one literal and references to it.
std::string Compressed() {
  const std::string packed("\x01\x40\x40\xE0\x83\x01", 6);  // 2 literals, 142 copied
  std::string bytes = Header(kXyz, "WIDTH 4\nHEIGHT 3\nPOINTS 12\n", "binary_compressed");
  Append(bytes, static_cast<std::uint32_t>(packed.size())), Append(bytes, std::uint32_t{144});
  return bytes + packed;
}

std::vector<std::string> Seeds() {
  const std::string ascii = "FIELDS x y z rgb intensity\nSIZE 4 4 4 4 4\nTYPE F F F U F\n";
  return {Header(ascii, "WIDTH 3\nHEIGHT 1\nVIEWPOINT 1 2 3 1 0 0 0\nPOINTS 3\n", "ascii") +
              "1 -2.5 3e1 16711935 0.25\r\nnan 0 0 0 0\n+0.5 0 0 255 7\n",
          Header("COLUMNS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\n", "POINTS 2\n", "ascii") +
              "1 2 3 1.4e-40\n0 0 0 2.3e-38",
          Header(kRich, "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 0 1 0 0\n", "binary") + RichRecords(4),
          Header(kXyz, "WIDTH 0\n", "binary"), Compressed()};
}

/// Packed data of the length that its header states, or mutations would rarely reach LZF. Inputs
/// that end in an even byte stay as they are.
std::string FileOf(std::string_view input) {
  std::string bytes(input);
  const std::size_t data = bytes.find(kCompressed);
  if (data == std::string::npos || (static_cast<unsigned char>(bytes.back()) & 1U) == 0) {
    return bytes;
  }
  const std::size_t sizes = data + kCompressed.size();
  if (bytes.size() < sizes + 8) return bytes;
  StoreBytes(&bytes[sizes], static_cast<std::uint32_t>(bytes.size() - sizes - 8));
  return bytes;
}

}  // namespace

FuzzTarget TargetUnderTest() { return {&ReadSingle<&OpenPcd>, &Seeds, &FileOf}; }

}  // namespace backsight
