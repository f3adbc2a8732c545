#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/artifacts/pair_units.h"
#include "pipeline/pair_pipeline.h"
#include "stages/network_solution.h"

namespace backsight {

/// A pair that was not tried, and why (a reason code of links.csv).
struct SkippedPair {
  int source = 0;
  int target = 0;
  std::string reason;
};

struct PairDiscovery {
  std::vector<Pair> pairs;           ///< tried, by target, then source
  std::vector<SkippedPair> skipped;  ///< in the same order
  int full = 0;                      ///< full registrations, second tries included
  int predicted = 0;                 ///< fine registrations from a predicted pose
  int components = 0;                ///< of usable stations, by the accepted pairs
  LinkSelection network;             ///< of all pairs together
};

/// An attempt at a pair that a discovery needs next, and all it starts from.
struct PairTask {
  int source = 0;
  int target = 0;
  PairMethod method = PairMethod::kFull;
  std::optional<RigidTransform> predicted;  ///< of PairMethod::kPredicted
  std::string before;                       ///< PairBytes of what is known of the pair
  std::string digest;                       ///< Pair::digest of that
};

/// Where a discovery comes to its end for want of results.
struct DiscoveryFrontier {
  std::vector<PairTask> missing;  ///< of one batch; none: the store holds all of the discovery
  std::size_t done = 0;           ///< attempts that the store holds
};

/// Finds the pairs of a campaign and registers them (docs/stages/pair_selection.md): all of them
/// where the stations are few, otherwise the most similar ones until the network is connected and
/// controlled, then those that its poses predict. `spec.include` pairs are tried in any case,
/// `spec.exclude` never. Accepted motions that contradict the stations' priors become rejected.
/// `early` are not registered again. The same pairs in the same order for any number of threads.
PairDiscovery DiscoverPairs(const PairUnits& units, const PairSpec& spec,
                            RegisteredPairs early = {});

/// Goes through the same discovery as far as the store holds its results, and registers nothing.
DiscoveryFrontier FindFrontier(const PairUnits& units, const PairSpec& spec);

}  // namespace backsight
