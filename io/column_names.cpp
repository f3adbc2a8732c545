#include "io/column_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "io/text_fields.h"

namespace backsight {
namespace {

struct KnownNames {
  NameMeaning meaning;
  std::vector<std::string_view> names;
};

/// Umlauts as UTF-8 and as Latin-1, as older software writes them; ToLower leaves them as they are.
const std::vector<KnownNames>& AllNames() {
  static const std::vector<KnownNames> all = {
      {NameMeaning::kX,
       {"x", "easting", "eastings", "east", "e", "rechtswert", "rechts", "rw", "ost", "ostwert",
        "point_x", "x_coordinate"}},
      {NameMeaning::kY,
       {"y", "northing", "northings", "north", "n", "hochwert", "hoch", "hw", "nord", "nordwert",
        "point_y", "y_coordinate"}},
      {NameMeaning::kZ,
       {"z", "height", "heights", "h", "elevation", "elev", "el", "altitude", "alt", "hoehe",
        "h\xC3\xB6he", "h\xC3\x96he", "h\xF6he", "h\xD6he", "point_z", "z_coordinate"}},
      {NameMeaning::kIntensity,
       {"intensity", "i", "scalar_intensity", "reflectance", "intensitaet", "intensit\xC3\xA4t"}},
      {NameMeaning::kRed, {"r", "red", "rot"}},
      {NameMeaning::kGreen, {"g", "green", "gruen", "gr\xC3\xBCn"}},
      {NameMeaning::kBlue, {"b", "blue", "blau"}},
      {NameMeaning::kNoCoordinate,
       {"pt",    "pnr",         "nr",        "no",       "id",      "name",        "point",
        "punkt", "punktnummer", "time",      "gps_time", "gpstime", "lat",         "latitude",
        "lon",   "long",        "longitude", "breite",   "laenge",  "l\xC3\xA4nge"}}};
  return all;
}

/// Without a unit of metres: "Easting [m]", "easting(m)", "easting_m".
std::string WithoutUnit(std::string name) {
  for (const std::string_view unit : {"[m]", "(m)", "_m"}) {
    if (name.size() > unit.size() && name.ends_with(unit)) name.resize(name.size() - unit.size());
  }
  return std::string(Trim(name));
}

constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};

bool IsCoordinate(NameMeaning meaning) { return meaning <= NameMeaning::kZ; }

}  // namespace

NameMeaning MeaningOf(std::string_view name) {
  const std::string key = WithoutUnit(ToLower(name));
  for (const KnownNames& known : AllNames()) {
    if (std::find(known.names.begin(), known.names.end(), key) != known.names.end()) {
      return known.meaning;
    }
  }
  return NameMeaning::kUnknown;
}

std::size_t CoordinatesNamed(std::span<const std::string> names) {
  return static_cast<std::size_t>(
      std::count_if(names.begin(), names.end(),
                    [](const std::string& name) { return IsCoordinate(MeaningOf(name)); }));
}

TextColumns ColumnsByNames(std::span<const std::string> names) {
  TextColumns columns(names.size(), TextColumn::kSkip);
  const auto has = [&](TextColumn column) {
    return std::find(columns.begin(), columns.end(), column) != columns.end();
  };
  const auto give = [&](bool axes_themselves) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const NameMeaning meaning = MeaningOf(names[i]);
      if (meaning >= NameMeaning::kNoCoordinate || columns[i] != TextColumn::kSkip) continue;
      const auto column = static_cast<TextColumn>(meaning);
      const bool itself =
          IsCoordinate(meaning) && WithoutUnit(ToLower(names[i])) == kAxes.at(std::size_t(meaning));
      if ((itself || !axes_themselves) && !has(column)) columns[i] = column;
    }
  };
  give(true);
  give(false);
  if (!has(TextColumn::kX) || !has(TextColumn::kY) || !has(TextColumn::kZ)) return {};
  if (!(has(TextColumn::kRed) && has(TextColumn::kGreen) && has(TextColumn::kBlue))) {
    for (TextColumn& column : columns) {
      if (column >= TextColumn::kRed) column = TextColumn::kSkip;
    }
  }
  return columns;
}

std::string ContradictionOf(std::span<const std::string> names, std::size_t columns) {
  std::vector<std::pair<NameMeaning, std::string>> coordinates;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const NameMeaning meaning = MeaningOf(names[i]);
    if (IsCoordinate(meaning)) coordinates.emplace_back(meaning, names[i]);
    if (names.size() != columns || meaning == NameMeaning::kUnknown) continue;
    const bool fits = IsCoordinate(meaning) ? std::size_t(meaning) == i : i >= kAxes.size();
    if (fits) continue;
    const std::string meant =
        IsCoordinate(meaning) ? fmt::format(", which is {},", kAxes.at(std::size_t(meaning))) : "";
    return i < kAxes.size()
               ? fmt::format("{}{} over the column of {}", Quoted(names[i]), meant, kAxes.at(i))
               : fmt::format("{}{} over column {}", Quoted(names[i]), meant, i + 1);
  }
  const auto before = std::adjacent_find(coordinates.begin(), coordinates.end(),
                                         [](const auto& a, const auto& b) { return a > b; });
  if (names.size() == columns || before == coordinates.end()) return "";
  return fmt::format("{} before {}", Quoted(before->second), Quoted(std::next(before)->second));
}

}  // namespace backsight
