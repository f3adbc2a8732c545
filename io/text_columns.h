#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace backsight {

/// What a column of a text cloud holds.
enum class TextColumn { kX, kY, kZ, kIntensity, kRed, kGreen, kBlue, kSkip };

/// The columns of a text cloud from the left; empty: not given, to be guessed.
using TextColumns = std::vector<TextColumn>;

/// "x", "y", "z", "intensity", "r", "g", "b" and "skip" (a column that is not read), in the order
/// of TextColumn.
const std::vector<std::string>& TextColumnNames();

inline constexpr std::size_t kMaxTextColumns = 256;

/// What is wrong with the columns: they are more than kMaxTextColumns, one of x, y, z is missing,
/// one of the others but skip comes twice, r, g and b are not all there or all absent. Empty if
/// nothing.
std::string FaultOf(const TextColumns& columns);

/// "x,y,z,skip": names between commas. Throws InputError, `where` in it, for anything else.
TextColumns ParseTextColumns(const std::string& list, const std::string& where);

}  // namespace backsight
