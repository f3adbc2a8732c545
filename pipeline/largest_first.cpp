#include "pipeline/largest_first.h"

#include <algorithm>
#include <atomic>
#include <numeric>

namespace backsight {

void LargestFirst(const std::vector<double>& weights, const ExecutionContext& context,
                  const std::function<void(std::size_t)>& body) {
  std::vector<std::size_t> order(weights.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return weights[a] > weights[b]; });
  // Whoever is free takes the next; the loop's own index follows another order.
  std::atomic<std::size_t> next = 0;
  context.ParallelFor(order.size(), [&](std::size_t) { body(order[next++]); });
}

}  // namespace backsight
