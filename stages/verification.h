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
  double max_conflict = 0.7;  ///< share of the surfaces in view that the scanner saw through
};
void VisitOptions(OptionVisitor& visitor, VerificationOptions& options);

struct VerificationInput {
  const StationModel& source;
  const StationModel& target;
  /// Both scanners stood at the origins of their frames, so that their views can be compared.
  bool scanners_credible = true;
  const CoarseResult& coarse;
  const FineResult& fine;
  /// Standard deviation of the levelling of both stations together, radians; absent where not both
  /// are levelled.
  std::optional<double> level_sigma_rad;
};

/// Whether a registered pair can be believed, and what speaks against it.
struct VerificationResult {
  enum class Reason {
    kNone,              ///< accepted
    kNotRegistered,     ///< the coarse registration found no motion
    kNotSignificant,    ///< its consensus could be chance
    kLowOverlap,        ///< too little of one cloud falls on the other
    kFineDiverged,      ///< the planes pull away from the correspondences
    kTilted,            ///< levelled instruments would stand at an angle
    kFreeSpace,         ///< one scanner saw through surfaces that the other would put there
    kContradictsPrior,  ///< the priors of both stations rule the motion out
  };
  Reason reason = Reason::kNone;
  double conflict = 0.0;  ///< share of surfaces in view that a scanner saw through, the worse side
  double overlap = 0.0;   ///< share of voxels that meet an occupied voxel, the smaller direction
  bool accepted() const { return reason == Reason::kNone; }
};

/// The reason code of links.csv, e.g. "low_overlap"; empty for kNone.
std::string ToString(VerificationResult::Reason reason);

/// Share of `moved`'s voxels whose mean, carried by `reference_from_moved`, falls into or beside an
/// occupied voxel of `reference`. 0 to 1. Of more than 20,000 voxels an even sample is taken.
double OverlapShare(const StationModel& moved, const StationModel& reference,
                    const RigidTransform& reference_from_moved);

/// Share of `moved`'s voxels in view of `reference`'s scanner that it saw through: it measured
/// something clearly behind them. Voxels that it could not see are neutral. 0 to 1; 0 if none is in
/// view.
double FreeSpaceConflict(const StationModel& moved, const StationModel& reference,
                         const RigidTransform& reference_from_moved);

/// How well a motion lays `moved` on `reference`: the share of (at most 3,000) voxels that meet a
/// surface of like normal, minus the share that the reference's scanner saw through where it is
/// known. For choosing between hypotheses.
double CloudScore(const Surface& moved, const Surface& reference,
                  const RigidTransform& reference_from_moved, bool scanners_credible);

VerificationResult VerifyPair(const VerificationInput& input, const VerificationOptions& options);

}  // namespace backsight
