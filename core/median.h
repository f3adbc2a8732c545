#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace backsight {

/// The middle value, of an even number the upper of both; of one value at least.
inline double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace backsight
