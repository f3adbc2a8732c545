#include "stages/verification.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"

namespace backsight {
namespace {

using Reason = VerificationResult::Reason;

constexpr double kSigmas = 3.0;  // between rivals

/// Mean of both directions' ratios; of the one that there is where only one scanner is credible.
RatioEstimate Together(const RatioEstimate& a, bool has_a, const RatioEstimate& b, bool has_b) {
  if (!has_a || !has_b) return has_a ? a : has_b ? b : RatioEstimate{};
  return {0.5 * (a.value + b.value), 0.5 * std::hypot(a.sigma, b.sigma)};
}

void MeasureClouds(const VerificationInput& input, const RigidTransform& motion,
                   VerificationResult* result) {
  // Tight, so that furniture that differs by centimetres decides; never tighter than the planes.
  const double tolerance_m =
      std::max(0.3 * input.target.model.resolution_m(), 3.0 * input.fine.rms_m);
  result->source_in_target = CompareClouds(input.source, input.source_index.sample, input.target,
                                           input.target_index, motion, tolerance_m);
  result->target_in_source = CompareClouds(input.target, input.target_index.sample, input.source,
                                           input.source_index, motion.Inverse(), tolerance_m);
  result->overlap = std::min(result->source_in_target.overlap, result->target_in_source.overlap);
  result->conflict =
      Together(result->source_in_target.conflict, result->source_in_target.blocks_in_view > 0,
               result->target_in_source.conflict, result->target_in_source.blocks_in_view > 0);
  result->quality =
      Together(result->source_in_target.quality, true, result->target_in_source.quality, true);
}

void MeasureChange(const VerificationInput& input, VerificationResult* result) {
  const RigidTransform& motion = input.fine.target_from_source;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  const std::vector<Eigen::Vector3d>& points = input.source_index.sample.points;
  for (const Eigen::Vector3d& point : points) center += point / static_cast<double>(points.size());
  result->apart_m =
      (motion * input.source.model.range_image.origin() - input.target.model.range_image.origin())
          .norm();
  result->shift_l =
      (motion * center - input.start * center).norm() / input.target.model.resolution_m();
  result->turn_rad = RotationAngle(motion.rotation, input.start.rotation);
  result->weakest_sigma_m = input.fine.weakest_sigma_m;
  result->eigenvalue_ratio = input.fine.eigenvalue_ratio;
}

/// The fit that proves what is hardly contradicted. Levelled stations can stand to each other in so
/// few ways that the best of all were compared (stages/plan_correlation.h); false ones among them
/// were seen through wherever they fit as closely, unless they are exact symmetries, which their
/// rivals reveal. Of predicted motions nothing was compared.
double ProvingQuality(const VerificationInput& input, const VerificationOptions& options) {
  const bool compared = input.level_sigma_rad && input.consensus;
  return compared ? std::min(options.level_quality, options.sure_quality) : options.sure_quality;
}

/// Whether a motion has proved itself on the clouds, whatever chance could have proposed: each
/// scanner saw much of the other's surfaces, hardly ever through them, and they fit closely.
bool CloudsProve(const VerificationInput& input, const VerificationOptions& options,
                 const VerificationResult& result) {
  return input.source.scanner_credible && input.target.scanner_credible &&
         result.overlap >= options.sure_overlap &&
         result.worst_conflict() < options.sure_conflict &&
         result.quality.value >= ProvingQuality(input, options) &&
         std::min(result.source_in_target.blocks_in_view, result.target_in_source.blocks_in_view) >=
             kFewestBlocksInView;
}

/// Whether the clouds lend some weight to what chance could have proposed: hardly anything was seen
/// through, or little of what fits well enough to prove it if nothing were.
bool CloudsSpeakFor(const VerificationInput& input, const VerificationOptions& options,
                    const VerificationResult& result) {
  const bool close = result.quality.value >= ProvingQuality(input, options);
  const double allowed = close ? 2.0 : 1.0;
  return result.sighted && result.overlap >= options.sure_overlap &&
         result.worst_conflict() < allowed * options.sure_conflict;
}

/// Whether the pattern of the beams may hold a direction that nothing else does: from one place
/// they fall on any surface alike, in rings on the ground, and the means of voxels follow them.
bool IsHeldByBeams(const VerificationInput& input, const VerificationResult& result) {
  constexpr double kOnePlace = 10.0;  // l
  return input.fine.status != FineResult::Status::kRefined && input.source.scanner_credible &&
         input.target.scanner_credible &&
         result.apart_m < kOnePlace * input.target.model.resolution_m();
}

/// Whether a direction is held by nothing: not even a voxel's width determines it.
bool IsUndetermined(const VerificationInput& input, const VerificationResult& result) {
  return result.weakest_sigma_m > input.target.model.resolution_m() || IsHeldByBeams(input, result);
}

/// What forbids a pair whatever the network says; kNone if nothing does.
Reason FindFault(const VerificationInput& input, const VerificationOptions& options,
                 const VerificationResult& result) {
  if (input.fine.status == FineResult::Status::kDiverged) return Reason::kFineDiverged;
  // What chance could have proposed needs clouds that speak for it.
  const bool could_be_chance =
      input.consensus && !IsSignificant(*input.consensus, input.consensus_null, options);
  if (could_be_chance && !CloudsSpeakFor(input, options, result)) return Reason::kNotSignificant;
  // What the network predicts fits the network whatever the clouds say; where they leave a
  // direction open, or all, it only repeats the prediction.
  if (!input.consensus && result.quality.value < options.min_quality) {
    return Reason::kNotSignificant;
  }
  const bool unrefined = input.fine.status == FineResult::Status::kTooFewPlanes;
  if (!input.consensus && (unrefined || IsUndetermined(input, result))) {
    return Reason::kUndetermined;
  }
  if (result.overlap < options.min_overlap) return Reason::kLowOverlap;
  if (input.level_sigma_rad) {
    const double limit = LargestTilt(*input.level_sigma_rad);
    if (RelativeTilt(input.fine.target_from_source) > limit) return Reason::kTilted;
  }
  return result.worst_conflict() >= options.max_conflict ? Reason::kFreeSpace : Reason::kNone;
}

/// Whether the refined motion is farther from its start than that could be wrong: 4 l and 1 deg, or
/// five of the start's own standard deviations where they are larger.
bool IsFarFromStart(const VerificationInput& input, const VerificationResult& result) {
  constexpr double kTurn = 0.017453292519943295;  // 1 deg
  constexpr double kShift = 4.0;                  // l
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> rotation(
      Eigen::Matrix3d(input.start_information.topLeftCorner<3, 3>()));
  const double sigma = 1.0 / std::sqrt(std::max(rotation.eigenvalues()[0], 1e-6));
  return result.shift_l > kShift || result.turn_rad > std::max(kTurn, 5.0 * sigma);
}

/// By more than their scatter and by more than `bias`.
bool Exceeds(const RatioEstimate& a, const RatioEstimate& b, double bias = 0.0) {
  return a.value - b.value > std::max(bias, kSigmas * std::hypot(a.sigma, b.sigma));
}

/// Whether the clouds rule out the place that the refinement began from. Both places are so near
/// each other that scanners see and sample the surfaces alike: none is preferred by how they do.
bool CloudsRefuteStart(const VerificationInput& input, const VerificationResult& end) {
  VerificationResult start;
  MeasureClouds(input, input.start, &start);
  const bool better = Exceeds(start.conflict, end.conflict) || Exceeds(end.quality, start.quality);
  const bool worse = Exceeds(end.conflict, start.conflict) || Exceeds(start.quality, end.quality);
  return better && !worse;
}

/// What leaves a pair to the network; kNone if nothing does.
Reason FindDoubt(const VerificationInput& input, const VerificationOptions& options,
                 const VerificationResult& result) {
  // What the network predicts must not confirm the links that it was predicted from: without proof
  // of its own it needs theirs.
  const bool by_chance =
      input.consensus && !IsSignificant(*input.consensus, input.consensus_null, options);
  const bool unproved = !input.consensus || by_chance;
  if (unproved && !CloudsProve(input, options, result)) return Reason::kNotSignificant;
  if (result.overlap < options.sure_overlap) return Reason::kLowOverlap;
  if (result.worst_conflict() >= options.sure_conflict) return Reason::kFreeSpace;
  // A start that chance could have proposed says nothing where the clouds prove the end and rule
  // out the start.
  const bool far = IsFarFromStart(input, result);
  if (far && !(by_chance && CloudsRefuteStart(input, result))) return Reason::kFarFromStart;
  return IsUndetermined(input, result) ? Reason::kUndetermined : Reason::kNone;
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, VerificationOptions& options) {
  visitor.Integer("min_consensus", options.min_consensus, "1", 3, 10000,
                  "fewest corresponding key points of an accepted pair");
  visitor.Integer("min_above_chance", options.min_above_chance, "1", 0, 1000,
                  "by how many they must exceed what shuffled correspondences reach");
  visitor.Real("min_overlap", options.min_overlap, "1", 0.0, 1.0,
               "share of each cloud that must fall on the other, or the pair is rejected");
  visitor.Real("sure_overlap", options.sure_overlap, "1", 0.0, 1.0,
               "share below which a pair is doubtful");
  visitor.Real("sure_quality", options.sure_quality, "1", 0.0, 1.0,
               "fit of the surfaces that meet from which a pair with few corresponding key points "
               "is accepted by its clouds alone");
  visitor.Real("level_quality", options.level_quality, "1", 0.0, 1.0,
               "the same between levelled stations, whose motions are compared by their plans; at "
               "most sure_quality");
  visitor.Real("min_quality", options.min_quality, "1", 0.0, 1.0,
               "fit of the surfaces that meet below which a pair that the network predicts is "
               "rejected");
  visitor.Real("sure_conflict", options.sure_conflict, "1", 0.0, 1.0,
               "share of the surfaces in view, seen through by a scanner, that makes a pair "
               "doubtful");
  visitor.Real("max_conflict", options.max_conflict, "1", 0.0, 1.0,
               "share of the surfaces in view, seen through by a scanner, that rejects a pair");
}

double LargestTilt(double level_sigma_rad) {
  constexpr double kModelError = 0.3 * 0.017453292519943295;  // 0.3 deg
  return 5.0 * level_sigma_rad + kModelError;
}

bool IsSignificant(int consensus, int consensus_null, const VerificationOptions& options) {
  return consensus >= std::max(options.min_consensus, consensus_null + options.min_above_chance);
}

std::string ToString(Reason reason) {
  static constexpr std::array<const char*, 11> kNames = {"",
                                                         "not_registered",
                                                         "not_significant",
                                                         "low_overlap",
                                                         "fine_diverged",
                                                         "tilted",
                                                         "free_space_conflict",
                                                         "far_from_start",
                                                         "undetermined",
                                                         "ambiguous",
                                                         "contradicts_prior"};
  return kNames.at(static_cast<std::size_t>(reason));
}

std::string ToString(Verdict verdict) {
  static constexpr std::array<const char*, 3> kNames = {"accepted", "doubtful", "rejected"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

double VerificationResult::worst_conflict() const {
  return std::max(source_in_target.conflict.value, target_in_source.conflict.value);
}

VerificationResult VerifyPair(const VerificationInput& input, const VerificationOptions& options) {
  BACKSIGHT_CHECK(input.fine.target_from_source.IsValid(), "a registered pair has a rigid motion");
  VerificationResult result;
  result.consensus = input.consensus.value_or(0);
  result.consensus_null = input.consensus_null;
  result.sighted = input.source.scanner_credible || input.target.scanner_credible;
  MeasureClouds(input, input.fine.target_from_source, &result);
  MeasureChange(input, &result);
  result.reason = FindFault(input, options, result);
  if (result.reason != Reason::kNone) return result;
  result.reason = FindDoubt(input, options, result);
  result.verdict = result.reason == Reason::kNone ? Verdict::kAccepted : Verdict::kDoubtful;
  return result;
}

bool IsContradictedMore(const VerificationResult& a, const VerificationResult& b) {
  // Mixed pixels and grazing views contradict true motions a little, the more the farther apart the
  // scanners stand, and a flip that puts them on mirrored places not at all.
  constexpr double kViewBias = 0.02;
  return Exceeds(a.conflict, b.conflict, kViewBias);
}

bool IsClearlyBetter(const VerificationResult& best, const VerificationResult& rival) {
  // A motion that puts both scanners on mirrored places makes them sample the surfaces alike, and
  // fits better than the true one, which has them apart, by up to 0.12 in an empty hall: only
  // contradictions tell such motions apart.
  constexpr double kSamplingBias = 0.05;
  constexpr double kMirrorBias = 0.15;
  constexpr double kNearer = 0.8;  // what scanners' distances may differ by and still sample alike
  const double blind = best.apart_m < kNearer * rival.apart_m ? kMirrorBias : kSamplingBias;
  const double bias = best.sighted && rival.sighted ? blind : 0.0;
  return IsContradictedMore(rival, best) || Exceeds(best.quality, rival.quality, bias);
}

void MarkAmbiguous(VerificationResult* result) {
  if (!result->accepted()) return;
  result->verdict = Verdict::kDoubtful;
  result->reason = Reason::kAmbiguous;
}

}  // namespace backsight
