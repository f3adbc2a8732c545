#include "pipeline/link_records.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

namespace backsight {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

std::string FineStatusName(FineResult::Status status) {
  switch (status) {
    case FineResult::Status::kRefined:
      return "refined";
    case FineResult::Status::kRefinedOnSurfaces:
      return "refined_on_surfaces";
    case FineResult::Status::kWeak:
      return "weak";
    case FineResult::Status::kTooFewPlanes:
      return "too_few_planes";
    case FineResult::Status::kDiverged:
      return "diverged";
  }
  return "";
}

std::string RefinementName(const NetworkRefinementResult& refinement) {
  using Result = NetworkRefinementResult;
  switch (refinement.status) {
    case Result::Status::kRefined:
      return "refined";
    case Result::Status::kTooFewPlanes:
      return "too_few_planes";
    case Result::Status::kKeptPoseGraph:
      break;
  }
  switch (refinement.reason) {
    case Result::Reason::kCostDidNotFall:
      return "kept_pose_graph_cost_did_not_fall";
    case Result::Reason::kStationMovedTooFar:
      return "kept_pose_graph_station_moved_too_far";
    case Result::Reason::kHeldOutPlanesWorse:
      return "kept_pose_graph_held_out_planes_worse";
    case Result::Reason::kNotFinite:
      return "kept_pose_graph_not_finite";
    case Result::Reason::kNone:
      break;
  }
  return "kept_pose_graph";
}

/// Of the place of the source's scanner in the target's frame, from the registration's own
/// information; absent where that leaves a direction open.
std::optional<WorstPlaceRecord> FindWorstPlace(const FineResult& fine) {
  if (fine.status == FineResult::Status::kTooFewPlanes ||
      fine.status == FineResult::Status::kDiverged) {
    return std::nullopt;
  }
  const Eigen::LDLT<Matrix6d> solver(fine.information);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
  const Eigen::Matrix<double, 3, 6> jacobian = PointJacobian(fine.target_from_source.translation);
  const Eigen::Matrix3d covariance = jacobian * solver.solve(jacobian.transpose());
  if (!covariance.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
  return WorstPlaceRecord{axes.eigenvectors().col(2),
                          std::sqrt(std::max(0.0, axes.eigenvalues()[2]))};
}

/// What registration and verification found of one motion.
void FillMotion(const Station& source, const Station& target, const PairCandidate& motion,
                LinkRecord* record) {
  const auto in_station_frames = [&](const RigidTransform& target_from_source) {
    return target.model.StationFromInstrument() * target_from_source *
           source.model.StationFromInstrument().Inverse();
  };
  const VerificationResult& verification = motion.verification;
  record->coarse = in_station_frames(motion.coarse.target_from_source);
  record->fine = in_station_frames(motion.fine.target_from_source);
  record->consensus = motion.coarse.consensus;
  record->predicted = motion.predicted;
  record->fine_status = FineStatusName(motion.fine.status);
  record->overlap = verification.overlap;
  record->conflict = verification.worst_conflict();
  record->agreement = verification.quality.value;
  record->planes = motion.fine.planes;
  if (motion.fine.rms_m > 0.0) record->rms_m = motion.fine.rms_m;
  if (motion.fine.weakest_sigma_m > 0.0) record->weakest_sigma_m = motion.fine.weakest_sigma_m;
  record->iterations = motion.fine.iterations;
  record->worst_place = FindWorstPlace(motion.fine);
}

/// How far the link lies from where the adjusted network has its stations, if in one component.
void FillResidual(const Network& network, const Pair& pair, LinkRecord* record) {
  const auto source = static_cast<std::size_t>(pair.source);
  const auto target = static_cast<std::size_t>(pair.target);
  const int component = network.component[source];
  if (component < 0 || component != network.component[target]) return;
  const RigidTransform adjusted =
      network.survey_from_station[target].Inverse() * network.survey_from_station[source];
  record->network_residual_m = (record->fine->translation - adjusted.translation).norm();
  record->network_residual_deg =
      RotationAngle(record->fine->rotation, adjusted.rotation) * kDegrees;
}

/// What the network made of it. Covariances are carried from instrument to station frames.
void FillNetwork(const Station& target, const NetworkCandidate& candidate, LinkRecord* record) {
  record->network_weight = candidate.used() ? 1.0 : 0.0;
  if (candidate.used()) {
    record->status = LinkStatus::kAccepted;
    record->reason.clear();
    record->loop_controlled = candidate.loop_controlled;
    const Matrix6d adjoint = Adjoint(target.model.StationFromInstrument());
    record->covariance = adjoint * candidate.covariance * adjoint.transpose();
    return;
  }
  const bool unconfirmed = candidate.fate == LinkFate::kUnconfirmed && !candidate.refuted;
  record->status = unconfirmed ? LinkStatus::kDoubtful : LinkStatus::kRejected;
  // Why it is doubtful says more than that nothing confirms it.
  const bool has_doubt = unconfirmed && !record->reason.empty();
  if (candidate.refuted) {
    record->reason = "refuted_by_views";
  } else if (!has_doubt) {
    record->reason = ToString(candidate.fate);
  }
}

LinkRecord MakeLinkRecord(const std::vector<Station>& stations, const Network& network,
                          const Pair& pair, int reported) {
  const Station& source = stations[static_cast<std::size_t>(pair.source)];
  const Station& target = stations[static_cast<std::size_t>(pair.target)];
  LinkRecord record;
  record.source = source.spec.id;
  record.target = target.spec.id;
  record.correspondences = pair.correspondences;
  record.consensus_null = pair.consensus_null;
  record.candidates = static_cast<int>(pair.candidates.size());
  if (!pair.fault.empty()) {
    record.reason = pair.fault;
    return record;
  }
  record.status = LinkStatus::kRejected;
  record.reason = ToString(pair.reason());
  if (pair.candidates.empty()) return record;
  if (reported < 0) {
    FillMotion(source, target, *pair.best(), &record);
    return record;
  }
  const NetworkCandidate& candidate = network.candidates[static_cast<std::size_t>(reported)];
  FillMotion(source, target, pair.candidates[static_cast<std::size_t>(candidate.candidate)],
             &record);
  FillResidual(network, pair, &record);
  record.network_residual_sigmas = candidate.residual_sigmas;
  FillNetwork(target, candidate, &record);
  return record;
}

/// Held-out planes by station pair; a < b.
std::map<std::pair<int, int>, HeldOutRecord> HeldOutByPair(const Network& network) {
  std::map<std::pair<int, int>, HeldOutRecord> records;
  for (const NetworkPart& part : network.parts) {
    for (const HeldOutPair& pair : part.refinement.held_out) {
      records[{part.stations[static_cast<std::size_t>(pair.a)],
               part.stations[static_cast<std::size_t>(pair.b)]}] = {
          pair.planes, pair.rms_before, pair.rms_after, pair.bias_before, pair.bias_after};
    }
  }
  return records;
}

/// Motions of the used link between two stations, coarse and fine, second from first.
struct UsedMotion {
  RigidTransform coarse, fine;
};

double AngleDeg(const RigidTransform& loop) {
  return RotationAngle(loop.rotation, Eigen::Matrix3d::Identity()) * kDegrees;
}

}  // namespace

std::vector<LinkRecord> MakeLinkRecords(const std::vector<Station>& stations,
                                        const std::vector<Pair>& pairs, const Network& network) {
  const auto held_out = HeldOutByPair(network);
  std::vector<LinkRecord> records;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    records.push_back(MakeLinkRecord(stations, network, pairs[p], network.reported[p]));
    const auto found = held_out.find(std::minmax(pairs[p].source, pairs[p].target));
    if (found != held_out.end()) records.back().held_out = found->second;
  }
  return records;
}

std::vector<ClosureRecord> MakeClosureRecords(const std::vector<Station>& stations,
                                              const std::vector<Pair>& pairs,
                                              const Network& network) {
  std::map<std::pair<int, int>, UsedMotion> motions;
  std::vector<std::vector<int>> after(stations.size());  // linked stations of higher index
  for (const NetworkCandidate& used : network.candidates) {
    if (!used.used()) continue;
    const Pair& pair = pairs[static_cast<std::size_t>(used.pair)];
    const PairCandidate& motion = pair.candidates[static_cast<std::size_t>(used.candidate)];
    motions[{pair.source, pair.target}] = {motion.coarse.target_from_source,
                                           motion.fine.target_from_source};
    motions[{pair.target, pair.source}] = {motion.coarse.target_from_source.Inverse(),
                                           motion.fine.target_from_source.Inverse()};
    after[static_cast<std::size_t>(std::min(pair.source, pair.target))].push_back(
        std::max(pair.source, pair.target));
  }
  std::vector<ClosureRecord> records;
  for (std::size_t a = 0; a < after.size(); ++a) {
    std::sort(after[a].begin(), after[a].end());
    for (const int b : after[a]) {
      for (const int c : after[a]) {
        const auto bc = motions.find({b, c});
        if (c <= b || bc == motions.end()) continue;
        const UsedMotion& ab = motions.at({static_cast<int>(a), b});
        const UsedMotion& ca = motions.at({c, static_cast<int>(a)});
        const RigidTransform coarse = ca.coarse * bc->second.coarse * ab.coarse;
        const RigidTransform fine = ca.fine * bc->second.fine * ab.fine;
        records.push_back({{stations[a].spec.id, stations[static_cast<std::size_t>(b)].spec.id,
                            stations[static_cast<std::size_t>(c)].spec.id},
                           coarse.translation.norm(),
                           AngleDeg(coarse),
                           fine.translation.norm(),
                           AngleDeg(fine)});
      }
    }
  }
  return records;
}

std::vector<ComponentRecord> MakeComponentRecords(const std::vector<Station>& stations,
                                                  const Network& network) {
  std::vector<ComponentRecord> records;
  for (std::size_t p = 0; p < network.parts.size(); ++p) {
    const NetworkPart& part = network.parts[p];
    const NetworkRefinementResult& refinement = part.refinement;
    ComponentRecord record;
    record.component = static_cast<int>(p);
    record.stations = static_cast<int>(part.stations.size());
    record.links = part.links;
    record.redundancy = 6 * (part.links - record.stations + 1);
    record.sigma_factor = network.solution.sigma_factor;
    record.refinement = RefinementName(refinement);
    record.planes = refinement.planes;
    record.observations = refinement.observations;
    record.rounds = static_cast<int>(refinement.rounds.size());
    for (const RefinementRound& round : refinement.rounds) {
      record.iterations += round.iterations;
      record.anderson_accepted += round.anderson_accepted;
    }
    if (refinement.status == NetworkRefinementResult::Status::kRefined) {
      record.plane_sigma_factor = std::sqrt(refinement.variance_factor);
    }
    if (refinement.weakest.station >= 0) {
      record.weakest_station =
          stations[static_cast<std::size_t>(
                       part.stations[static_cast<std::size_t>(refinement.weakest.station)])]
              .spec.id;
      record.weakest_sigma_m = refinement.weakest.sigma_m;
    }
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace backsight
