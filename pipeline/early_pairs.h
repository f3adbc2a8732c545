#pragma once

#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

#include "pipeline/artifacts/pair_units.h"
#include "pipeline/pair_prospects.h"
#include "pipeline/work_queue.h"

namespace backsight {

/// Registers pairs beside the loading of stations: those that a discovery registers in full
/// whatever ranks say (IsCertain), each as soon as both of its stations are there.
class EarlyPairs {
 public:
  /// Both must outlive it.
  EarlyPairs(const PairUnits& units, const PairSpec& spec);

  /// The station is there and usable: its pairs with those that were there before join the queue,
  /// behind stations; but for those of stations that will be refused as copies. From any thread.
  /// Where memory does not suffice for a pair, a discovery tries it again.
  void Join(std::size_t station, WorkQueue* queue);

  /// What was registered, once no work is left.
  RegisteredPairs Take() { return std::move(registered_); }

 private:
  bool IsCopy(std::size_t station);
  void AddPair(std::size_t one, std::size_t other, WorkQueue* queue);
  bool IsThere(std::size_t station);
  void Register(std::size_t source, std::size_t target);

  const PairUnits& units_;
  PairRules rules_;
  std::mutex mutex_;
  std::vector<std::size_t> there_;
  RegisteredPairs registered_;
};

}  // namespace backsight
