#include "pipeline/artifacts/network_artifact.h"

#include "core/archive.h"

namespace backsight {

template <class Archive>
void Transfer(Archive& archive, PoseGraphResult& poses) {
  archive(poses.survey_from_station, poses.component, poses.weights, poses.covariance, poses.cost,
          poses.rounds, poses.converged);
}

template <class Archive>
void Transfer(Archive& archive, LinkSupport& support) {
  archive(support.valid, support.invalid, support.confirmed);
}

template <class Archive>
void Transfer(Archive& archive, TriangleClosure& closure) {
  archive(closure.a, closure.b, closure.c, closure.rotation_deg, closure.translation_m,
          closure.squared_error);
}

template <class Archive>
void Transfer(Archive& archive, WeakestDirection& weakest) {
  archive(weakest.sigma_m, weakest.station, weakest.station_m, weakest.station_deg, weakest.lever_m,
          weakest.axis);
}

template <class Archive>
void Transfer(Archive& archive, Ambiguity& ambiguity) {
  archive(ambiguity.stations, ambiguity.for_kept, ambiguity.for_rival, ambiguity.margin,
          ambiguity.noise, ambiguity.shift_m, ambiguity.turn_deg);
}

template <class Archive>
void Transfer(Archive& archive, NetworkResult& result) {
  archive(result.poses, result.fate, result.loop_controlled, result.link_covariance, result.support,
          result.sigma_factor, result.cycle_sigma_factor, result.redundancy, result.closures,
          result.covariance, result.weakest, result.ambiguities, result.removed, result.readmitted,
          result.moves);
}

template <class Archive>
void Transfer(Archive& archive, NetworkCandidate& candidate) {
  archive(candidate.pair, candidate.candidate, candidate.fate, candidate.refuted,
          candidate.loop_controlled, candidate.covariance, candidate.residual_sigmas);
}

template <class Archive>
void Transfer(Archive& archive, RefinementRound& round) {
  archive(round.planes, round.observations, round.surface_matches, round.iterations,
          round.anderson_accepted, round.anderson_start, round.cost_before, round.cost_after,
          round.largest_move_m);
}

template <class Archive>
void Transfer(Archive& archive, WeakestMotion& weakest) {
  archive(weakest.sigma_m, weakest.station, weakest.direction);
}

template <class Archive>
void Transfer(Archive& archive, SquaredChange& change) {
  archive(change.mean_before_m2, change.mean_change_m2, change.standard_error_m2);
}

template <class Archive>
void Transfer(Archive& archive, HeldOutPair& pair) {
  archive(pair.a, pair.b, pair.planes, pair.rms_before, pair.rms_after, pair.bias_before,
          pair.bias_after, pair.change);
}

template <class Archive>
void Transfer(Archive& archive, NetworkRefinementResult& result) {
  archive(result.status, result.reason, result.station, result.survey_from_station,
          result.covariance, result.sigma0_m, result.agreement_factor, result.variance_factor,
          result.surface_factor, result.block_m, result.planes, result.observations,
          result.planes_of_station, result.rounds, result.weakest, result.held_out);
}

template <class Archive>
void Transfer(Archive& archive, NetworkPart& part) {
  archive(part.stations, part.links, part.refinement);
}

template <class Archive>
void Transfer(Archive& archive, PlacementConflict& conflict) {
  archive(conflict.a, conflict.b, conflict.conflict, conflict.blocks_in_view);
}

template <class Archive>
void Transfer(Archive& archive, PlacementCheckResult& check) {
  archive(check.pairs_compared, check.conflicts, check.refuted_bridge);
}

template <class Archive>
void Transfer(Archive& archive, Network& network) {
  archive(network.solution, network.candidates, network.reported, network.component, network.parts,
          network.check, network.survey_from_station, network.covariance);
}

template <class Archive>
void Transfer(Archive& archive, MovingLeaves& moving) {
  archive(moving.leaves, moving.points);
}

template <class Archive>
void Transfer(Archive& archive, MovingPoints& moving) {
  archive(moving.stations);
}

std::string NetworkBytes(const Network& network) { return ToBytes(network); }

Network NetworkFrom(std::string_view bytes) { return FromBytes<Network>(bytes); }

std::string MovingPointsBytes(const MovingPoints& moving) { return ToBytes(moving); }

MovingPoints MovingPointsFrom(std::string_view bytes) { return FromBytes<MovingPoints>(bytes); }

}  // namespace backsight
