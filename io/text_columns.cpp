#include "io/text_columns.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "io/text_fields.h"

namespace backsight {

const std::vector<std::string>& TextColumnNames() {
  static const std::vector<std::string> names = {"x", "y", "z", "intensity", "r", "g", "b", "skip"};
  return names;
}

std::string FaultOf(const TextColumns& columns) {
  if (columns.size() > kMaxTextColumns) return fmt::format("{} columns", columns.size());
  const auto count = [&](TextColumn column) {
    return std::count(columns.begin(), columns.end(), column);
  };
  const auto name = [](TextColumn column) -> const std::string& {
    return TextColumnNames()[static_cast<std::size_t>(column)];
  };
  for (const TextColumn column : {TextColumn::kX, TextColumn::kY, TextColumn::kZ}) {
    if (count(column) == 0) return "no " + name(column);
  }
  for (const TextColumn column : columns) {
    if (column != TextColumn::kSkip && count(column) > 1) return name(column) + " twice";
  }
  const auto colours =
      count(TextColumn::kRed) + count(TextColumn::kGreen) + count(TextColumn::kBlue);
  return colours == 0 || colours == 3 ? "" : fmt::format("{} of r, g and b", colours);
}

TextColumns ParseTextColumns(const std::string& list, const std::string& where) {
  const std::vector<std::string>& names = TextColumnNames();
  std::vector<std::string_view> words(list.size() + 1);
  words.resize(SplitFields(list, ',', words));
  TextColumns columns;
  std::string fault;
  for (const std::string_view word : words) {
    const auto found = std::find(names.begin(), names.end(), word);
    if (found == names.end() && fault.empty()) fault = Quoted(word);
    columns.push_back(static_cast<TextColumn>(found - names.begin()));
  }
  if (fault.empty()) fault = FaultOf(columns);
  if (fault.empty()) return columns;
  throw InputError({where, fault,
                    fmt::format("each column once, of {}, between commas", fmt::join(names, ", ")),
                    "like x,y,z,skip,r,g,b"});
}

}  // namespace backsight
