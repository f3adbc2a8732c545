#include "pipeline/early_pairs.h"

#include <algorithm>
#include <new>
#include <optional>

namespace backsight {

EarlyPairs::EarlyPairs(const PairUnits& units, const PairSpec& spec)
    : units_(units), rules_(spec) {}

void EarlyPairs::Join(std::size_t station, WorkQueue* queue) {
  const std::lock_guard lock(mutex_);
  if (IsCopy(station)) return;
  try {
    for (const std::size_t other : there_) AddPair(station, other, queue);
    there_.push_back(station);
  } catch (const std::bad_alloc&) {  // its other pairs come when all stations are there
  }
}

/// Whether an earlier station has the same points; a later one that has is there no more.
bool EarlyPairs::IsCopy(std::size_t station) {
  const auto& content = units_.stations()[station].content_fingerprint;
  const auto same = std::find_if(there_.begin(), there_.end(), [&](std::size_t other) {
    return units_.stations()[other].content_fingerprint == content;
  });
  if (same == there_.end()) return false;
  if (*same < station) return true;
  there_.erase(same);
  return false;
}

void EarlyPairs::AddPair(std::size_t one, std::size_t other, WorkQueue* queue) {
  const std::vector<Station>& stations = units_.stations();
  const auto [target, source] = std::minmax(one, other);
  const PairProspect pair = rules_.ProspectOf(stations, source, target);
  if (!IsCertain(pair, static_cast<int>(stations.size()), units_.options().pair_selection)) return;
  const auto leaves_of = [&](std::size_t s) {
    return static_cast<double>(stations[s].model.leaves.size());
  };
  queue->Add({.group_weight = leaves_of(target), .group = pair.target, .weight = leaves_of(source)},
             [this, s = source, t = target] { Register(s, t); });
}

bool EarlyPairs::IsThere(std::size_t station) {
  const std::lock_guard lock(mutex_);
  return std::find(there_.begin(), there_.end(), station) != there_.end();
}

void EarlyPairs::Register(std::size_t source, std::size_t target) {
  if (!IsThere(source) || !IsThere(target)) return;  // found to be a copy meanwhile
  Pair pair;
  pair.source = static_cast<int>(source);
  pair.target = static_cast<int>(target);
  units_.Register(PairMethod::kFull, std::nullopt, &pair);
  if (pair.short_of_memory) return;  // there may be more when the stations are all there
  const std::lock_guard lock(mutex_);
  try {
    registered_.emplace(std::pair(pair.source, pair.target), std::move(pair));
  } catch (const std::bad_alloc&) {  // likewise
  }
}

}  // namespace backsight
