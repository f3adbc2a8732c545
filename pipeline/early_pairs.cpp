#include "pipeline/early_pairs.h"

#include <algorithm>

namespace backsight {

EarlyPairs::EarlyPairs(const PairUnits& units, const PairSpec& spec)
    : units_(units), rules_(spec) {}

void EarlyPairs::Join(std::size_t station, WorkQueue* queue) {
  const std::vector<Station>& stations = units_.stations();
  const std::lock_guard lock(mutex_);
  for (const std::size_t other : there_) {
    const auto [target, source] = std::minmax(station, other);
    const bool is_copy =
        stations[source].content_fingerprint == stations[target].content_fingerprint;
    const PairProspect pair = rules_.ProspectOf(stations, source, target);
    if (is_copy ||
        !IsCertain(pair, static_cast<int>(stations.size()), units_.options().pair_selection)) {
      continue;
    }
    const auto leaves_of = [&](std::size_t s) {
      return static_cast<double>(stations[s].model.leaves.size());
    };
    queue->Add(
        {.group_weight = leaves_of(target), .group = pair.target, .weight = leaves_of(source)},
        [this, s = pair.source, t = pair.target] { Register(s, t); });
  }
  there_.push_back(station);
}

void EarlyPairs::Register(int source, int target) {
  Pair pair;
  pair.source = source;
  pair.target = target;
  units_.Register(PairMethod::kFull, std::nullopt, &pair);
  if (pair.short_of_memory) return;  // there may be more when the stations are all there
  const std::lock_guard lock(mutex_);
  registered_.emplace(std::pair(source, target), std::move(pair));
}

}  // namespace backsight
