#pragma once

#include <span>
#include <vector>

#include "core/execution.h"
#include "core/option_visitor.h"
#include "core/rigid_transform.h"
#include "stages/cloud_agreement.h"
#include "stages/surface.h"

namespace backsight {

struct PlacementCheckOptions {
  double max_conflict = 0.25;  ///< share of blocks in view that a scanner may have seen through
  int min_blocks = 20;         ///< fewer blocks in view say nothing
};
void VisitOptions(OptionVisitor& visitor, PlacementCheckOptions& options);

/// A link that the network uses.
struct PlacedLink {
  int source = 0;
  int target = 0;
  bool loop_controlled = true;  ///< false: a bridge, its ends hang together only through it
};

/// A placed network. Indices are those of the stations; frames are instrument and survey.
struct PlacementCheckInput {
  std::vector<const Surface*> stations;    ///< null: not usable
  std::vector<const CloudIndex*> indices;  ///< of their models
  std::vector<RigidTransform> survey_from_station;
  std::vector<int> component;  ///< stations of one component share a frame
  std::vector<PlacedLink> links;
};

/// What two placed stations, linked or not, say of each other: the worse of both directions.
struct PlacementConflict {
  int a = 0;
  int b = 0;              ///< a < b
  double conflict = 0.0;  ///< share of the blocks in view that a scanner saw through
  int blocks_in_view = 0;
};

struct PlacementCheckResult {
  int pairs_compared = 0;
  std::vector<PlacementConflict> conflicts;  ///< those beyond max_conflict, ascending
  /// The bridge (index of a link) whose two sides contradict each other most and beyond
  /// max_conflict, all their stations taken together; -1: none. Only one: a false bridge in a chain
  /// puts stations wrong on both sides of the true ones, too.
  int refuted_bridge = -1;
};

/// Looks from every placed station at what all others of its component measured. A pair is verified
/// by itself; this adds the pairs that nobody linked, so that a wrong bridge between two parts of a
/// network is found out by the stations on its sides. Stations farther apart than the larger of
/// their ranges are not compared. Time: some milliseconds per pair of neighbours.
PlacementCheckResult CheckPlacements(const PlacementCheckInput& input,
                                     const PlacementCheckOptions& options,
                                     const ExecutionContext& context);

}  // namespace backsight
