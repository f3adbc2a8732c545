#include "io/ply_reader.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/io/append_bytes.h"

namespace backsight {
namespace {

/// Faces before the points, so that lists must be stepped over.
std::string Binary(std::endian order) {
  std::string bytes = "ply\nformat binary_";
  bytes += order == std::endian::big ? "big" : "little";
  bytes +=
      "_endian 1.0\ncomment any\nelement face 2\nproperty list uchar int vertex_indices\n"
      "property short kind\nelement vertex 3\nproperty float64 x\nproperty float y\n"
      "property int z\nproperty ushort red\nproperty ushort green\nproperty ushort blue\n"
      "property uchar intensity\nend_header\n";
  for (const std::uint8_t corners : {std::uint8_t{3}, std::uint8_t{0}}) {
    Append(bytes, corners, order);
    for (std::int32_t i = 0; i < corners; ++i) Append(bytes, i, order);
    Append(bytes, std::int16_t{-1}, order);
  }
  for (int i = 0; i < 3; ++i) {
    Append(bytes, i + 0.5, order), Append(bytes, -2.25F, order);
    Append(bytes, std::int32_t{i - 1}, order);
    for (std::uint16_t c = 0; c < 3; ++c) Append(bytes, static_cast<std::uint16_t>(c * i), order);
    Append(bytes, static_cast<std::uint8_t>(100 * i), order);
  }
  return bytes;
}

/// Points that carry a list themselves.
std::string Ragged() {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement empty 7\nelement vertex 2\n"
      "property char x\nproperty uint8 y\nproperty list uint double any\nproperty int64 z\n"
      "property float intensity\nend_header\n";
  for (const std::uint32_t entries : {2U, 0U}) {
    bytes += "\x01\x02";
    Append(bytes, entries);
    for (std::uint32_t i = 0; i < entries; ++i) Append(bytes, 0.5);
    Append(bytes, std::int64_t{-3}), Append(bytes, 0.75F);
  }
  return bytes;
}

std::vector<std::string> Seeds() {
  return {Binary(std::endian::little), Binary(std::endian::big), Ragged(),
          "ply\r\nformat ascii 1.0\r\nobj_info any\r\nelement vertex 2\r\nproperty double x\r\n"
          "property double y\r\nproperty double z\r\nproperty uchar red\r\nproperty uchar green\r\n"
          "property uchar blue\r\nproperty float scalar_Intensity\r\nelement face 1\r\n"
          "property list uchar int vertex_indices\r\nend_header\r\n"
          "0.1 0.2 0.3 255 0 1 0.5\r\n1 2 nan 1 2 3 0.5\r\n3 0 1 1\r\n",
          "ply\nformat ascii 1.0\nelement edge 1\nproperty list uint8 float w\nelement vertex 1\n"
          "property float z\nproperty list char int8 q\nproperty float y\nproperty float x\n"
          "property float red\nproperty float green\nproperty float blue\nend_header\n"
          "2 0.5 0.5\n1 3 1 2 3 -1 1e3 0.5 0 1"};
}

}  // namespace

FuzzTarget TargetUnderTest() { return {&ReadSingle<&OpenPly>, &Seeds, &AsItIs}; }

}  // namespace backsight
