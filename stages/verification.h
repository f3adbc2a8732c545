#pragma once

#include <optional>

#include "core/option_visitor.h"
#include "stages/coarse_registration.h"
#include "stages/fine_registration.h"
#include "stages/station_model.h"

namespace backsight {

struct VerificationOptions {
  int min_consensus = 10;    ///< distinct key points
  int min_above_chance = 4;  ///< consensus beyond what shuffled correspondences reach
  double min_overlap = 0.1;
};
void VisitOptions(OptionVisitor& visitor, VerificationOptions& options);

struct VerificationInput {
  const StationModel& source;
  const StationModel& target;
  const CoarseResult& coarse;
  const FineResult& fine;
  /// Standard deviation of the levelling of both stations together, radians; absent where not both
  /// are levelled.
  std::optional<double> level_sigma_rad;
};

/// Whether a registered pair can be believed, and what speaks against it.
struct VerificationResult {
  enum class Reason {
    kNone,            ///< accepted
    kNotRegistered,   ///< the coarse registration found no motion
    kNotSignificant,  ///< its consensus could be chance
    kLowOverlap,      ///< too little of one cloud falls on the other
    kFineDiverged,    ///< the planes pull away from the correspondences
    kTilted,          ///< levelled instruments would stand at an angle
  };
  Reason reason = Reason::kNone;
  double overlap = 0.0;  ///< share of voxels that meet an occupied voxel, the smaller direction
  bool accepted() const { return reason == Reason::kNone; }
};

/// The reason code of links.csv, e.g. "low_overlap"; empty for kNone.
std::string ToString(VerificationResult::Reason reason);

/// Share of `moved`'s voxels whose mean, carried by `reference_from_moved`, falls into or beside an
/// occupied voxel of `reference`. 0 to 1. Of more than 20,000 voxels an even sample is taken.
double OverlapShare(const StationModel& moved, const StationModel& reference,
                    const RigidTransform& reference_from_moved);

VerificationResult VerifyPair(const VerificationInput& input, const VerificationOptions& options);

}  // namespace backsight
