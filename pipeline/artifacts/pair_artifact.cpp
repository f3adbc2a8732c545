#include "pipeline/artifacts/pair_artifact.h"

#include "core/archive.h"

namespace backsight {

template <class Archive>
void Transfer(Archive& archive, CoarseCandidate& coarse) {
  archive(coarse.target_from_source, coarse.information, coarse.consensus, coarse.inliers,
          coarse.sigma_m, coarse.cloud_score);
}

template <class Archive>
void Transfer(Archive& archive, FineResult& fine) {
  archive(fine.status, fine.target_from_source, fine.information, fine.planes, fine.rms_m,
          fine.weakest_sigma_m, fine.weakest_direction, fine.eigenvalue_ratio, fine.surface_matches,
          fine.iterations, fine.anderson_accepted);
}

template <class Archive>
void Transfer(Archive& archive, RatioEstimate& ratio) {
  archive(ratio.value, ratio.sigma);
}

template <class Archive>
void Transfer(Archive& archive, CloudAgreement& agreement) {
  archive(agreement.overlap, agreement.score, agreement.conflict, agreement.blocks_in_view,
          agreement.quality);
}

template <class Archive>
void Transfer(Archive& archive, VerificationResult& result) {
  archive(result.verdict, result.reason, result.sighted, result.overlap, result.source_in_target,
          result.target_in_source, result.conflict, result.quality, result.consensus,
          result.consensus_null, result.apart_m, result.shift_l, result.turn_rad,
          result.weakest_sigma_m, result.eigenvalue_ratio);
}

template <class Archive>
void Transfer(Archive& archive, PairCandidate& candidate) {
  archive(candidate.coarse, candidate.fine, candidate.verification, candidate.predicted);
}

template <class Archive>
void Transfer(Archive& archive, Pair& pair) {
  archive(pair.correspondences, pair.consensus_null, pair.candidates, pair.predicted);
}

std::string PairBytes(const Pair& pair) { return ToBytes(pair); }

void RestorePair(std::string_view bytes, Pair* pair) {
  Pair restored = FromBytes<Pair>(bytes);
  restored.source = pair->source;
  restored.target = pair->target;
  *pair = std::move(restored);
}

}  // namespace backsight
