#include "io/geo_keys.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <vector>

#include "io/endian_bytes.h"
#include "io/text_fields.h"

namespace backsight {
namespace {

enum class Kind { kModel, kCode, kText, kUnit };

struct KnownKey {
  std::uint16_t id;
  Kind kind;
  std::string_view name;
};

constexpr std::array<KnownKey, 10> kKnown{{{1024, Kind::kModel, "model"},
                                           {1026, Kind::kText, "citation"},
                                           {2048, Kind::kCode, "geodetic"},
                                           {2049, Kind::kText, "geodetic citation"},
                                           {3072, Kind::kCode, "projected"},
                                           {3073, Kind::kText, "projected citation"},
                                           {3076, Kind::kUnit, "unit"},
                                           {4096, Kind::kCode, "vertical"},
                                           {4097, Kind::kText, "vertical citation"},
                                           {4099, Kind::kUnit, "vertical unit"}}};

constexpr std::uint16_t kTextLocation = 34737;
constexpr std::uint16_t kUndefined = 0;
constexpr std::uint16_t kUserDefined = 32767;
constexpr std::uint16_t kGeographic = 2;  // value of the model key
constexpr std::uint16_t kMetre = 9001;
constexpr std::uint16_t kFirstFoot = 9002;  // international, US survey and older feet
constexpr std::uint16_t kLastFoot = 9006;

}  // namespace

std::string DescribeGeoKeys(std::string_view directory, std::string_view text) {
  constexpr std::size_t kEntryBytes = 8;
  std::vector<std::string> words;
  for (std::size_t at = kEntryBytes; at + kEntryBytes <= directory.size(); at += kEntryBytes) {
    const auto part = [&](std::size_t i) {
      return LoadBytes<std::uint16_t>(directory.data() + at + 2 * i);
    };
    const auto value = part(3);
    for (const KnownKey& key : kKnown) {
      if (key.id != part(0)) continue;
      if (key.kind == Kind::kText) {
        if (part(1) != kTextLocation || value >= text.size()) continue;
        std::string_view citation = Trim(text.substr(value, part(2)));
        citation = citation.substr(0, citation.find('|'));
        if (!citation.empty()) words.push_back(fmt::format("{} '{}'", key.name, citation));
      } else if (key.kind == Kind::kModel) {
        if (value == kGeographic) words.emplace_back("geographic");
      } else if (value != kUndefined && value != kUserDefined) {
        if (key.kind == Kind::kUnit && value == kMetre) continue;
        const bool foot = key.kind == Kind::kUnit && value >= kFirstFoot && value <= kLastFoot;
        words.push_back(fmt::format("{} EPSG:{}{}", key.name, value, foot ? " (foot)" : ""));
      }
    }
  }
  if (words.empty()) return "";
  return fmt::format("GeoTIFF: {}", fmt::join(words, ", "));
}

}  // namespace backsight
