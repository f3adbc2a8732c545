#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "core/execution.h"

namespace backsight {

/// Runs body(i) for every weight i, on all threads, and begins with the largest, lest one of them
/// is left to run alone at the end; equal ones by index. Results must go to place i.
void LargestFirst(const std::vector<double>& weights, const ExecutionContext& context,
                  const std::function<void(std::size_t)>& body);

}  // namespace backsight
