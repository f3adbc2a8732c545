#include <algorithm>
#include <cstdint>

#include "io/endian_bytes.h"
#include "io/las_format.h"
#include "io/las_reader.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/io/las_bytes.h"

namespace backsight {
namespace {

constexpr std::uint16_t kWkt = 2112;
constexpr std::uint16_t kGeoKeys = 34735;
constexpr std::uint16_t kGeoText = 34737;

LasTestFile FileWith(int minor, int format, std::size_t points) {
  Random random(static_cast<std::uint64_t>(format));
  LasTestFile file;
  file.minor = minor;
  file.format = format;
  file.points = RandomLasPoints(format, points, random);
  return file;
}

std::vector<std::string> Seeds() {
  LasTestFile geo = FileWith(2, 3, 5);
  geo.encoding = 1;
  geo.records = {LasTestRecord("LASF_Projection", kGeoKeys,
                               GeoKeyBytes({{1024, 0, 1, 2},
                                            {1026, kGeoText, 4, 0},
                                            {3072, 0, 1, 25832},
                                            {3076, 0, 1, 9002},
                                            {4097, kGeoText, 9, 4}})),
                 LasTestRecord("LASF_Projection", kGeoText, "UTM|Höhe 17|"),
                 LasTestRecord("another", 7, "bytes")};
  LasTestFile wkt = FileWith(4, 7, 6);
  wkt.encoding = 17;
  wkt.extra_point_bytes = 3;
  wkt.records = {LasTestRecord("LASF_Projection", kWkt, "PROJCRS[\"Grüne Wiese\"]")};
  LasTestFile extended = FileWith(5, 8, 3);
  extended.encoding = 16 + 64;
  extended.time_offset = 900;
  extended.extended = {LasTestRecord("another", 1, "", true),
                       LasTestRecord("LASF_Projection", kWkt, "GEOGCRS[]", true)};
  LasTestFile plain = FileWith(0, 1, 4);
  plain.extra_header_bytes = 2;
  LasTestFile waves = FileWith(3, 5, 2);
  waves.encoding = 2;
  return {geo.Bytes(),
          wkt.Bytes(),
          extended.Bytes(),
          plain.Bytes(),
          waves.Bytes(),
          FileWith(4, 6, 0).Bytes(),
          FileWith(2, 0, 9).Bytes()};
}

/// Keeps the file a LAS file whose points begin within it and are no more than it can hold, as
/// nearly every insertion breaks that. Inputs that end in an odd byte stay as they are.
std::string FileOf(std::string_view input) {
  std::string bytes(input);
  if (bytes.size() < kLas12HeaderBytes || (static_cast<unsigned char>(bytes.back()) & 1U) != 0) {
    return bytes;
  }
  bytes.replace(0, 4, "LASF");
  bytes[LasAt::kVersion] = 1;
  const auto header =
      std::min<std::size_t>(LoadBytes<std::uint16_t>(&bytes[LasAt::kHeaderBytes]), bytes.size());
  StoreBytes(&bytes[LasAt::kHeaderBytes], static_cast<std::uint16_t>(header));
  const auto begin = std::clamp<std::size_t>(LoadBytes<std::uint32_t>(&bytes[LasAt::kPointOffset]),
                                             header, bytes.size());
  StoreBytes(&bytes[LasAt::kPointOffset], static_cast<std::uint32_t>(begin));
  const auto step =
      std::max<std::uint64_t>(LoadBytes<std::uint16_t>(&bytes[LasAt::kPointBytes]), 1);
  const std::uint64_t room = (bytes.size() - begin) / step;
  const auto limit = [&]<typename T>(std::size_t at, T) {
    if (at + sizeof(T) > bytes.size()) return;
    StoreBytes(&bytes[at], static_cast<T>(std::min<std::uint64_t>(LoadBytes<T>(&bytes[at]), room)));
  };
  limit(LasAt::kLegacyPoints, std::uint32_t{});
  if (bytes[LasAt::kVersion + 1] >= 4) limit(LasAt::kPoints, std::uint64_t{});
  return bytes;
}

}  // namespace

FuzzTarget TargetUnderTest() { return {&ReadSingle<&OpenLas>, &Seeds, &FileOf}; }

}  // namespace backsight
