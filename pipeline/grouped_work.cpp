#include "pipeline/grouped_work.h"

#include <algorithm>
#include <map>

#include "pipeline/work_queue.h"

namespace backsight {

void LargestGroupsFirst(const std::vector<GroupedWork>& works, const ExecutionContext& context,
                        const std::function<void(std::size_t)>& body) {
  std::map<int, double> of_group;
  for (const GroupedWork& work : works) {
    double& largest = of_group[work.group];
    largest = std::max(largest, work.weight);
  }
  WorkQueue queue(context);
  for (std::size_t i = 0; i < works.size(); ++i) {
    const GroupedWork& work = works[i];
    queue.Add({.group_weight = of_group[work.group], .group = work.group, .weight = work.weight},
              [&body, i] { body(i); });
  }
  queue.Run();
}

}  // namespace backsight
