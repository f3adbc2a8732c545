#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "io/point_collector.h"
#include "io/text_columns.h"

namespace backsight {

/// Which column of a text cloud means what.
struct XyzLayout {
  static constexpr std::size_t kNone = SIZE_MAX;

  std::size_t columns = 3;  ///< per line
  std::array<std::size_t, 3> xyz{0, 1, 2};
  std::size_t intensity = kNone;
  std::array<std::size_t, 3> rgb{kNone, kNone, kNone};
  IntensityRange intensity_range;
  ColorScale color_scale = ColorScale::k8Bit;

  bool HasIntensity() const { return intensity != kNone; }
  bool HasRgb() const { return rgb[0] != kNone; }
  /// What was decided, in words: "columns: x y z intensity (0 to 255)".
  std::string Describe() const;
};

/// Text clouds do not say what their columns mean. Goes by the number of columns (at least 3) and
/// the values of `sample`, lines of equal length: 3 x y z; 4 or 5 and an intensity; 6 or more with
/// three columns of whole numbers 0 to 255 (or 65535) a colour, before or behind the intensity.
/// `is_pts`: intensities may be -2048 to 2047.
XyzLayout GuessXyzLayout(std::span<const std::vector<double>> sample, bool is_pts);

/// The same for columns that are given or named, as many as each line of `sample` has: only the
/// ranges of intensity and colour go by its values.
XyzLayout GivenXyzLayout(const TextColumns& columns, std::span<const std::vector<double>> sample,
                         bool is_pts);

}  // namespace backsight
