#include "tests/io/e57/e57_bytes.h"

#include <array>

#include "core/random.h"
#include "io/e57/page_layout.h"
#include "io/endian_bytes.h"

namespace backsight {
namespace {

template <Arithmetic T>
void Append(std::string& bytes, T value, std::endian order = std::endian::little) {
  bytes.resize(bytes.size() + sizeof(T));
  StoreBytes(bytes.data() + bytes.size() - sizeof(T), value, order);
}

std::string Section(std::uint64_t start, const std::vector<std::string>& packets) {
  std::string body;
  for (const std::string& packet : packets) body += packet;
  std::string section("\x01\0\0\0\0\0\0\0", 8);
  Append(section, std::uint64_t{32 + body.size()});
  Append(section, E57Physical(start + 32));
  Append(section, std::uint64_t{0});
  return section + body;
}

std::string Finish(std::string payload, const std::string& xml) {
  const std::uint64_t xml_start = payload.size();
  payload += xml;
  const std::uint64_t pages = (payload.size() + kE57PayloadBytes - 1) / kE57PayloadBytes;
  std::string header = "ASTM-E57";
  Append(header, std::uint32_t{1});
  Append(header, std::uint32_t{0});
  Append(header, std::uint64_t{pages * kE57PageBytes});
  Append(header, E57Physical(xml_start));
  Append(header, std::uint64_t{xml.size()});
  Append(header, kE57PageBytes);
  return payload.replace(0, header.size(), header);
}

}  // namespace

std::uint32_t TableCrc32c(std::string_view bytes) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> remainders{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t crc = i;
      for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0x82F63B78U : 0U);
      remainders[i] = crc;
    }
    return remainders;
  }();
  std::uint32_t crc = ~0U;
  for (const char c : bytes) {
    crc = (crc >> 8U) ^ table[(crc ^ static_cast<unsigned char>(c)) & 0xFFU];
  }
  return ~crc;
}

std::string Paged(std::string_view payload) {
  std::string paged;
  for (std::size_t at = 0; at < payload.size(); at += kE57PayloadBytes) {
    std::string page(payload.substr(at, kE57PayloadBytes));
    page.resize(kE57PayloadBytes, '\0');
    Append(page, TableCrc32c(page), std::endian::big);
    paged += page;
  }
  return paged;
}

std::string Payload(std::string_view paged) {
  std::string payload;
  for (std::size_t at = 0; at + kE57PageBytes <= paged.size(); at += kE57PageBytes) {
    payload += paged.substr(at, kE57PayloadBytes);
  }
  return payload;
}

std::string PackBits(std::span<const std::uint64_t> values, unsigned bits) {
  std::string bytes((values.size() * bits + 7) / 8, '\0');
  std::size_t position = 0;
  for (const std::uint64_t value : values) {
    for (unsigned bit = 0; bit < bits; ++bit, ++position) {
      const auto set = static_cast<unsigned>((value >> bit & 1U) << (position % 8));
      bytes[position / 8] =
          static_cast<char>(static_cast<unsigned char>(bytes[position / 8]) | set);
    }
  }
  return bytes;
}

std::string DataPacket(const std::vector<std::string>& streams, std::uint8_t flags) {
  std::string body;
  Append(body, static_cast<std::uint16_t>(streams.size()));
  for (const std::string& stream : streams) {
    Append(body, static_cast<std::uint16_t>(stream.size()));
  }
  for (const std::string& stream : streams) body += stream;
  while (body.size() % 4 != 0) body += '\0';
  std::string packet = "\x01";
  Append(packet, flags);
  Append(packet, static_cast<std::uint16_t>(body.size() + 3));
  return packet + body;
}

std::string RootXml(std::string_view elements) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<e57Root type=\"Structure\" "
         "xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\">" +
         std::string(elements) + "</e57Root>\n";
}

std::string E57Payload(const std::vector<TestScan>& scans) {
  std::string payload(kE57HeaderBytes, '\0');
  std::string data3d;
  for (const TestScan& scan : scans) {
    data3d += "<vectorChild type=\"Structure\">" + scan.before_points +
              "<points type=\"CompressedVector\" fileOffset=\"" +
              std::to_string(E57Physical(payload.size())) + "\" recordCount=\"" +
              std::to_string(scan.records) + "\"><prototype type=\"Structure\">" + scan.prototype +
              "</prototype><codecs type=\"Vector\"/></points></vectorChild>";
    payload += Section(payload.size(), scan.packets);
  }
  return Finish(payload, RootXml("<data3D type=\"Vector\">" + data3d + "</data3D>"));
}

std::string E57PayloadOf(const std::vector<std::string>& packets, std::string xml) {
  std::string payload(kE57HeaderBytes, '\0');
  const std::string offset = std::to_string(E57Physical(payload.size()));
  payload += Section(payload.size(), packets);
  for (std::size_t at = xml.find('@'); at != std::string::npos; at = xml.find('@')) {
    xml.replace(at, 1, offset);
  }
  return Finish(payload, xml);
}

std::string RichE57Payload() {
  TestScan scan{
      "<guid type='String'>{G}</guid><pose type='Structure'><rotation type='Structure'>"
      "<w type='Float'>1</w></rotation></pose>",
      "<cartesianX type='Float'/><cartesianY type='Float' precision='single'/>"
      "<cartesianZ type='ScaledInteger' minimum='-100' maximum='400' scale='0.001'/>"
      "<intensity type='Integer' minimum='0' maximum='255'/>"
      "<cartesianInvalidState type='Integer' minimum='0' maximum='2'/>"
      "<colorRed type='Integer' minimum='7' maximum='7'/>"
      "<colorGreen type='Integer' minimum='0' maximum='255'/>"
      "<colorBlue type='Integer' minimum='0' maximum='65535'/>",
      168,
      {}};
  Random random(5);
  const auto bits = [&random](unsigned width, std::uint64_t below) {
    std::vector<std::uint64_t> values(56);
    for (std::uint64_t& value : values) value = random.Index(below);
    return PackBits(values, width);
  };
  for (int packet = 0; packet < 3; ++packet) {
    scan.packets.push_back(DataPacket(
        {PackNumbers(std::vector<double>(56, 1.25)), PackNumbers(std::vector<float>(56, 2.5F)),
         bits(9, 500), bits(8, 256), bits(2, 3), "", bits(8, 256), bits(16, 65536)}));
  }
  return E57Payload({scan, scan});
}

}  // namespace backsight
