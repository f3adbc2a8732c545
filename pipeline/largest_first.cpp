#include "pipeline/largest_first.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <numeric>
#include <tuple>

namespace backsight {

namespace {

/// The indices of the `keys`, the largest key's first; equal ones ascend.
template <class Key>
std::vector<std::size_t> Descending(const std::vector<Key>& keys) {
  std::vector<std::size_t> order(keys.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return keys[a] > keys[b]; });
  return order;
}

void RunInOrder(const std::vector<std::size_t>& order, const ExecutionContext& context,
                const std::function<void(std::size_t)>& body) {
  // Whoever is free takes the next; the loop's own index follows another order.
  std::atomic<std::size_t> next = 0;
  context.ParallelFor(order.size(), [&](std::size_t) { body(order[next++]); });
}

}  // namespace

void LargestFirst(const std::vector<double>& weights, const ExecutionContext& context,
                  const std::function<void(std::size_t)>& body) {
  RunInOrder(Descending(weights), context, body);
}

void LargestGroupsFirst(const std::vector<GroupedWork>& works, const ExecutionContext& context,
                        const std::function<void(std::size_t)>& body) {
  std::map<int, double> of_group;
  for (const GroupedWork& work : works) {
    double& largest = of_group[work.group];
    largest = std::max(largest, work.weight);
  }
  std::vector<std::tuple<double, int, double>> keys;  // equal groups stay apart
  keys.reserve(works.size());
  for (const GroupedWork& work : works) {
    keys.emplace_back(of_group[work.group], work.group, work.weight);
  }
  RunInOrder(Descending(keys), context, body);
}

}  // namespace backsight
