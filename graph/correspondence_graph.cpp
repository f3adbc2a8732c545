#include "graph/correspondence_graph.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "graph/pair_columns.h"
#include "graph/reliability_kernels.h"

namespace backsight {
namespace {

/// Few rows, which one thread sums in some milliseconds, share the work of each pair of them; many
/// share the threads instead. The bits are the same.
void SumSideBySide(const PairColumns& columns, const CompatibilityRule& rule,
                   const ExecutionContext& context, std::span<float> sums) {
  constexpr std::size_t kFew = 6000;
  if (sums.size() <= kFew || context.threads() == 1) {
    SumAllReliabilities(View(columns), rule, sums);
    return;
  }
  constexpr std::size_t kRows = 64;  // at a time
  context.ParallelFor((sums.size() + kRows - 1) / kRows, [&](std::size_t chunk) {
    const std::size_t begin = chunk * kRows;
    SumReliabilities(View(columns), rule, begin,
                     sums.subspan(begin, std::min(kRows, sums.size() - begin)));
  });
}

}  // namespace

ReliableNodes SelectReliableNodes(const Correspondences& c, const NodeReliabilityOptions& options,
                                  const ExecutionContext& context) {
  ReliableNodes result;
  if (c.size() == 0) return result;
  const PairColumns columns(c);
  const auto l = static_cast<float>(options.resolution_m);
  CompatibilityRule rule{2.0F * l, std::numeric_limits<float>::infinity(), 0.0F,
                         1.0F / (6.0F * l * l)};
  if (options.upright) {
    rule.height_m = 2.0F * l;
    rule.slope = static_cast<float>(options.upright->max_tilt_rad);
  }
  result.reliability.resize(c.size());
  SumSideBySide(columns, rule, context, result.reliability);

  result.rows.resize(c.size());
  std::iota(result.rows.begin(), result.rows.end(), 0U);
  const auto kept = static_cast<std::ptrdiff_t>(
      std::min(result.rows.size(), static_cast<std::size_t>(options.keep)));
  const auto is_before = [&](std::uint32_t a, std::uint32_t b) {
    const float of_a = result.reliability[a];
    const float of_b = result.reliability[b];
    return of_a != of_b ? of_a > of_b : a < b;
  };
  std::nth_element(result.rows.begin(), result.rows.begin() + kept, result.rows.end(), is_before);
  std::sort(result.rows.begin(), result.rows.begin() + kept, is_before);
  result.rows.resize(static_cast<std::size_t>(kept));
  return result;
}

}  // namespace backsight
