#pragma once

#include <optional>
#include <string>

#include "core/option_visitor.h"
#include "stages/cloud_agreement.h"
#include "stages/coarse_registration.h"
#include "stages/fine_registration.h"

namespace backsight {

struct VerificationOptions {
  int min_consensus = 10;        ///< distinct key points
  int min_above_chance = 4;      ///< consensus beyond what shuffled correspondences reach
  double min_overlap = 0.05;     ///< rejected below
  double sure_overlap = 0.1;     ///< doubtful below
  double sure_quality = 0.8;     ///< from here clouds make up for a consensus that is too small
  double level_quality = 0.65;   ///< the same between levelled stations, whose motions are compared
  double min_quality = 0.3;      ///< below it a predicted motion is rejected
  double sure_conflict = 0.025;  ///< doubtful from here: share of blocks seen through
  double max_conflict = 0.25;    ///< rejected from here
};
void VisitOptions(OptionVisitor& visitor, VerificationOptions& options);

/// By how much levelled instruments may be tilted against each other: five standard deviations of
/// both levellings together and 0.3 deg of model error. Radians.
double LargestTilt(double level_sigma_rad);

/// One significance rule for all who ask: the consensus must be clear of chance.
bool IsSignificant(int consensus, int consensus_null, const VerificationOptions& options);

struct VerificationInput {
  Surface source;
  Surface target;
  const CloudIndex& source_index;
  const CloudIndex& target_index;
  /// The transform that the fine registration started from: coarse or predicted.
  RigidTransform start;
  Matrix6d start_information = Matrix6d::Zero();
  /// Absent for a predicted pair: permutation says nothing of it, only the clouds can prove it.
  std::optional<int> consensus;
  int consensus_null = 0;
  const FineResult& fine;
  /// Standard deviation of the levelling of both stations together, radians; absent where not both
  /// are levelled.
  std::optional<double> level_sigma_rad;
};

enum class Verdict { kAccepted, kDoubtful, kRejected };

/// Whether a registered pair can be believed, and what speaks against it.
struct VerificationResult {
  enum class Reason {
    kNone,              ///< accepted
    kNotRegistered,     ///< the coarse registration found no motion
    kNotSignificant,    ///< its consensus could be chance, or it was predicted
    kLowOverlap,        ///< too little of one cloud falls on the other
    kFineDiverged,      ///< the planes pull away from the correspondences
    kTilted,            ///< levelled instruments would stand at an angle
    kFreeSpace,         ///< one scanner saw through surfaces that the other would put there
    kFarFromStart,      ///< refined farther away than the start can be in error
    kUndetermined,      ///< one direction is held by nothing, or by the pattern of the beams alone
    kAmbiguous,         ///< a rival motion fits as well
    kContradictsPrior,  ///< the priors of both stations rule the motion out
  };
  Verdict verdict = Verdict::kRejected;
  Reason reason = Reason::kNotRegistered;
  bool sighted = false;  ///< a scanner is credible, so that free space can contradict the motion
  double overlap = 0.0;  ///< share of voxels that meet an occupied voxel, the smaller direction
  CloudAgreement source_in_target;  ///< the source's cloud before the target's scanner
  CloudAgreement target_in_source;
  /// Both directions together: share of blocks in view that were seen through; for ranking rivals.
  RatioEstimate conflict;
  RatioEstimate quality;  ///< both directions: mean fit of the voxels that could fit
  int consensus = 0;
  int consensus_null = 0;
  double apart_m = 0.0;   ///< between the scanners under this motion
  double shift_l = 0.0;   ///< from the start to the refined motion at the overlap, in l
  double turn_rad = 0.0;  ///< likewise
  double weakest_sigma_m = 0.0;
  double eigenvalue_ratio = 0.0;

  bool accepted() const { return verdict == Verdict::kAccepted; }
  /// The worse direction's conflict.
  double worst_conflict() const;
};

/// The reason code of links.csv, e.g. "low_overlap"; empty for kNone.
std::string ToString(VerificationResult::Reason reason);
std::string ToString(Verdict verdict);

/// Judges one refined motion by itself; rivals are compared afterwards. About 50 ms.
VerificationResult VerifyPair(const VerificationInput& input, const VerificationOptions& options);

/// Whether scanners saw through significantly more of a pair's surfaces under `a` than under `b`:
/// by more than three standard deviations, from the scatter over groups as large as objects, and by
/// more than true motions are contradicted in still scenes (0.02).
bool IsContradictedMore(const VerificationResult& a, const VerificationResult& b);

/// Whether `rival` cannot be the true motion if `best` is another motion of the same pair: it is
/// contradicted more, or its surfaces fit less closely by more than three standard deviations.
bool IsClearlyBetter(const VerificationResult& best, const VerificationResult& rival);

/// Makes an accepted result doubtful: a rival is as good.
void MarkAmbiguous(VerificationResult* result);

}  // namespace backsight
