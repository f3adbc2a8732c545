#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_columns.h"

namespace backsight {

/// What surveyors' names of columns mean: x, easting, rechtswert, ...; y, northing, hochwert, ...;
/// z, height, elevation, ...; intensity and colours; in any case, with or without a unit of metres
/// behind them ("Easting [m]"). kNoCoordinate: known, and no metres of x, y or z (point name,
/// latitude).
enum class NameMeaning { kX, kY, kZ, kIntensity, kRed, kGreen, kBlue, kNoCoordinate, kUnknown };
NameMeaning MeaningOf(std::string_view name);

/// How many of `names` mean x, y or z.
std::size_t CoordinatesNamed(std::span<const std::string> names);

/// The columns by the names above them, those that mean nothing here to be skipped; empty where x,
/// y or z is not among them. Where two mean the same, x, y and z themselves come first, then the
/// one further to the left.
TextColumns ColumnsByNames(std::span<const std::string> names);

/// Why columns that begin with x y z, as their values suggest, contradict `names`: "'Northing',
/// which is y, over the column of x". Empty if they do not. Where there are not as many names as
/// `columns`, only the order of those that mean x, y or z counts.
std::string ContradictionOf(std::span<const std::string> names, std::size_t columns);

}  // namespace backsight
