#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "core/execution.h"

namespace backsight {

/// A piece of work that shares what is made of its group with the others of it.
struct GroupedWork {
  int group = 0;
  double weight = 0.0;
};

/// Runs body(i) for every work i, on all threads, and begins with the largest, lest one of them is
/// left to run alone at the end; but the works of one group follow one another, that of the largest
/// first. Results must go to place i.
void LargestGroupsFirst(const std::vector<GroupedWork>& works, const ExecutionContext& context,
                        const std::function<void(std::size_t)>& body);

}  // namespace backsight
