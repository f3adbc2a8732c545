#include <algorithm>

#include "io/e57/e57_reader.h"
#include "io/e57/page_layout.h"
#include "io/endian_bytes.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/io/e57/e57_bytes.h"

namespace backsight {
namespace {

constexpr std::size_t kFileBytes = 16;
constexpr std::size_t kXmlOffset = 24;
constexpr std::size_t kXmlBytes = 32;

std::vector<std::string> Seeds() {
  TestScan spherical{
      "<indexBounds><rowMaximum>3</rowMaximum><rowMinimum/><columnMinimum/>"
      "<columnMaximum type='Integer'>2</columnMaximum></indexBounds>"
      "<pose><rotation><w>2</w><x>1</x></rotation></pose>",
      "<sphericalRange type='Float'/><sphericalAzimuth type='Float'/>"
      "<sphericalElevation type='ScaledInteger' minimum='0' maximum='1023' "
      "scale='0.001' offset='-0.5'/><sphericalInvalidState type='Integer' "
      "minimum='0' maximum='2'/><rowIndex type='Integer'/><columnIndex "
      "type='Integer' minimum='0' maximum='2'/>",
      2,
      {}};
  const std::string reals = PackNumbers<double>({1.0, 2.0});
  spherical.packets = {DataPacket({reals, reals, "\1\2\3", std::string(1, 0), reals, "\1"})};
  TestScan nested{"",
                  "<n:a type='Structure'><b type='Vector'><c type='Integer'/></b></n:a>"
                  "<n:s type='String'/><cartesianX type='Float' precision='single'/>"
                  "<cartesianY type='Float'/><cartesianZ type='Integer' minimum='5' maximum='5'/>",
                  2,
                  {}};
  nested.packets = {DataPacket({reals, "\1a", PackNumbers<float>({1.0F, 2.0F}), reals, ""}),
                    std::string("\2\0\3\0", 4)};
  return {RichE57Payload(), E57Payload({spherical}), E57Payload({nested, spherical}),
          E57Payload({{"", "<cartesianX type='Float'/>", 0, {}}})};
}

/// Inputs are payloads, so that insertions do not tear the pages apart, and checksums are always
/// right. Where the header has lost the file's length or the XML, it is led back to them.
std::string FileOf(std::string_view input) {
  std::string payload(input.substr(0, std::size_t{1} << 20U));
  if (payload.size() < kE57HeaderBytes) payload.resize(kE57HeaderBytes);
  const std::uint64_t pages = (payload.size() + kE57PayloadBytes - 1) / kE57PayloadBytes;
  const auto number = [&payload](std::size_t at) { return LoadBytes<std::uint64_t>(&payload[at]); };
  if (number(kFileBytes) > pages * kE57PageBytes) {
    StoreBytes(&payload[kFileBytes], pages * kE57PageBytes);
  }
  const std::size_t xml = payload.find("<?xml");
  if (xml != std::string::npos && number(kXmlOffset) != E57Physical(xml)) {
    StoreBytes(&payload[kXmlOffset], E57Physical(xml));
  }
  const std::size_t end = payload.rfind('>');
  if (xml != std::string::npos && end > xml) {
    StoreBytes(&payload[kXmlBytes], std::uint64_t{end + 1 - xml});
  }
  return Paged(payload);
}

void Read(const std::string& path) { ReadScans(path, &OpenE57); }

}  // namespace

FuzzTarget TargetUnderTest() { return {&Read, &Seeds, &FileOf}; }

}  // namespace backsight
