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

/// A piece of work that shares what is made of its group with the others of it.
struct GroupedWork {
  int group = 0;
  double weight = 0.0;
};

/// The same, but the works of one group follow one another; the group of the largest comes first.
void LargestGroupsFirst(const std::vector<GroupedWork>& works, const ExecutionContext& context,
                        const std::function<void(std::size_t)>& body);

}  // namespace backsight
