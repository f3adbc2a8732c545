#include "stages/network_refinement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/anderson_acceleration.h"
#include "graph/planar_adjustment.h"
#include "graph/plane_segmentation.h"
#include "stages/dominant_frame.h"
#include "stages/plane_weights.h"
#include "stages/surface_links.h"

namespace backsight {
namespace {

using Status = NetworkRefinementResult::Status;
using Reason = NetworkRefinementResult::Reason;
using Poses = std::vector<RigidTransform>;

/// Planes of one association.
struct PlaneSets {
  std::vector<WeightedPlane> adjusted;
  std::vector<PlaneAssociation> held_out;
  int observations = 0;
  std::vector<int> of_station;
  std::vector<std::uint64_t> cells;
  Eigen::MatrixXi of_pair;
};

class Refinement {
 public:
  Refinement(const NetworkRefinementInput& input, const NetworkRefinementOptions& options,
             const ExecutionContext& context)
      : input_(input),
        options_(options),
        context_(context),
        accelerator_(std::max(options.anderson_window, 1)) {
    for (const StationModel* model : input.stations) {
      clusters_.emplace_back(model->leaves);
      l_ = std::max(l_, model->resolution_m());
      double squared = 0.0;
      for (const Eigen::Vector3d& mean : model->leaves.means()) squared += mean.squaredNorm();
      const auto count = static_cast<double>(std::max<std::size_t>(model->leaves.size(), 1));
      levers_m_.push_back(std::max(std::sqrt(squared / count), 1.0));
    }
    for (std::size_t s = 0; s < input.level_sigma_rad.size(); ++s) {
      if (!input.level_sigma_rad[s]) continue;
      tilts_.push_back({static_cast<int>(s), *input.level_sigma_rad[s]});
    }
    AlignLattice();
    KeepStart(Status::kTooFewPlanes, Reason::kNone);
  }

  NetworkRefinementResult Run() {
    if (input_.stations.size() < 2) return std::move(result_);
    Poses poses = input_.survey_from_station;
    for (int round = 0; round < options_.max_rounds; ++round) {
      Associate(poses, round);
      if (static_cast<int>(planes_.adjusted.size()) < options_.min_planes) {
        return std::move(result_);
      }
      MakeLinks();
      // Surfaces match by nearest voxels: only once planes have brought them together.
      if (round >= 1) ObserveSurfaces(poses);
      Poses moved = AdjustRound(poses);
      if (round >= 1) WeighSurfaces(moved);
      const double move_m = LargestMove(poses, moved);
      result_.rounds.back().largest_move_m = move_m;
      poses = std::move(moved);
      // The tolerances have reached their floor, and nothing moves any more.
      constexpr double kSettled = 2e-5;
      if (round >= 3 && move_m < kSettled) break;
    }
    Judge(poses);
    return std::move(result_);
  }

 private:
  /// Cells along the walls hold whole walls; cells across them hold corners, which pull on planes.
  void AlignLattice() {
    std::vector<Eigen::Vector3f> normals;
    for (std::size_t s = 0; s < input_.normals.size(); ++s) {
      const Eigen::Matrix3f rotation = input_.survey_from_station[s].rotation.cast<float>();
      constexpr std::size_t kOfStation = 400;
      const std::vector<Eigen::Vector3f>& own = *input_.normals[s];
      const std::size_t stride = std::max<std::size_t>(1, own.size() / kOfStation);
      for (std::size_t i = 0; i < own.size(); i += stride) normals.emplace_back(rotation * own[i]);
    }
    lattice_from_survey_.rotation = FindDominantFrame(normals).frame_from_cloud;
  }

  /// The start poses stand, with the covariance that the links give.
  void KeepStart(Status status, Reason reason) {
    result_.status = status;
    result_.reason = reason;
    result_.survey_from_station = input_.survey_from_station;
    const PlanarProblem links{{}, {{}, input_.links, {}}, nullptr};
    result_.covariance =
        InvertInformation(AssembleNormalEquations(links, input_.survey_from_station).matrix);
    if (result_.covariance.size() != 0) return;
    const auto rows = static_cast<Eigen::Index>(6 * input_.stations.size());
    result_.covariance = Eigen::MatrixXd::Zero(rows, rows);
    for (std::size_t s = 1; s < input_.stations.size(); ++s) {
      const auto row = static_cast<Eigen::Index>(6 * s);
      result_.covariance.block<6, 6>(row, row) = input_.covariance[s];
    }
  }

  void Associate(const Poses& poses, int round) {
    context_.CheckStop();
    PlaneSearchOptions search;
    search.root_edge_m = options_.root_edge * l_;
    search.max_thickness_m = options_.max_thickness_m;
    search.max_thinness = options_.max_thinness;
    NarrowTolerances(l_, round, &search);
    const auto stations = input_.stations.size();
    planes_ = {};
    planes_.of_station.assign(stations, 0);
    const auto rows = static_cast<Eigen::Index>(stations);
    planes_.of_pair = Eigen::MatrixXi::Zero(rows, rows);
    Poses lattice_poses;
    for (const RigidTransform& pose : poses) lattice_poses.push_back(lattice_from_survey_ * pose);
    for (PlaneAssociation& plane : FindPlanes(clusters_, lattice_poses, search, &context_)) {
      planes_.cells.push_back(plane.cell);
      if (IsHeldOut(plane.cell, options_.held_out_share)) {
        planes_.held_out.push_back(std::move(plane));
        continue;
      }
      for (PlaneObservation& o : plane.observations) {
        CapCount(options_.effective_points, &o.cluster);
        ++planes_.of_station[static_cast<std::size_t>(o.station)];
        for (const PlaneObservation& other : plane.observations) {
          ++planes_.of_pair(o.station, other.station);
        }
      }
      planes_.observations += static_cast<int>(plane.observations.size());
      planes_.adjusted.push_back({std::move(plane.observations), 1.0});
    }
  }

  /// A link's own planes are among ours: it may hold only what planes leave open, with the weight
  /// of a coarse registration (half a voxel). Where its stations share hardly a plane now, it is
  /// evidence of its own and counts in full.
  void MakeLinks() {
    context_.CheckStop();
    links_.clear();
    surfaces_ = {};
    for (PoseGraphLink link : input_.links) {
      if (planes_.of_pair(link.source, link.target) >= options_.min_planes) {
        const double shift = 0.5 * l_;
        const double turn = shift / levers_m_[static_cast<std::size_t>(link.target)];
        Vector6d coarse;
        coarse << Eigen::Vector3d::Constant(1.0 / (turn * turn)),
            Eigen::Vector3d::Constant(1.0 / (shift * shift));
        // (information^-1 + coarse^-1)^-1, also where the information is singular.
        const Matrix6d sum = link.information + Matrix6d(coarse.asDiagonal());
        const Matrix6d information =
            link.information - link.information * sum.ldlt().solve(link.information);
        link.information = 0.5 * (information + information.transpose());
      }
      links_.push_back(link);
    }
    all_links_ = links_;
  }

  PlanarProblem Problem() const { return {planes_.adjusted, {{}, all_links_, tilts_}, &context_}; }

  PrecisionInput Precision(const Poses& poses) const {
    return {
        planes_.adjusted, surfaces_.scores, {{}, links_, tilts_}, poses, options_.root_edge * l_};
  }

  /// Surfaces at `poses`, weighed against the planes as found so far.
  void ObserveSurfaces(const Poses& poses) {
    context_.CheckStop();
    if (!options_.surfaces || input_.normals.empty()) return;
    std::vector<std::uint64_t> cells = planes_.cells;
    std::sort(cells.begin(), cells.end());
    // Most voxels lie in none of them: bits of the cells, which are as good as random, tell.
    constexpr std::uint64_t kLowBits = 0xFFFF;
    std::vector<bool> taken(kLowBits + 1);
    for (const std::uint64_t cell : cells) taken[cell & kLowBits] = true;
    const auto covered = [&](std::size_t s, std::size_t i) {
      const Eigen::Vector3d point = lattice_from_survey_ * (poses[s] * clusters_[s][i].mean);
      for (int depth = 0; depth <= PlaneSearchOptions{}.max_depth; ++depth) {
        const std::uint64_t cell = PlaneCell(point, options_.root_edge * l_, depth);
        if (!taken[cell & kLowBits]) continue;
        if (std::binary_search(cells.begin(), cells.end(), cell)) return true;
      }
      return false;
    };
    const SurfaceMatcher matcher(input_.stations, input_.normals, covered, context_);
    surfaces_ = matcher.Observe(input_.links, poses, options_.root_edge * l_,
                                1.0 / result_.surface_factor, context_);
    all_links_.insert(all_links_.end(), surfaces_.links.begin(), surfaces_.links.end());
  }

  /// Variance components: how much larger surfaces' errors are than planes', each against what its
  /// formal variance says.
  void WeighSurfaces(const Poses& poses) {
    if (surfaces_.scores.empty()) return;
    context_.CheckStop();
    const PrecisionInput input = Precision(poses);
    const Eigen::MatrixXd formal =
        InvertInformation(ScanInformation(input, context_) +
                          AssembleNormalEquations({{}, input.others, nullptr}, poses).matrix);
    if (formal.size() == 0) return;
    const double edge = 4.0 * options_.root_edge * l_;
    const auto factor = [&](const PrecisionInput& group) {
      const std::vector<std::uint64_t> blocks = SpatialBlocks(group, edge);
      return EstimateVarianceFactor({group.planes, group.surfaces, blocks}, poses, formal, context_)
          .factor;
    };
    const double of_planes = factor({input.planes, {}, {}, poses, edge});
    const double of_surfaces = factor({{}, input.surfaces, {}, poses, edge});
    result_.surface_factor *= of_surfaces / of_planes;
  }

  Poses AdjustRound(const Poses& poses) {
    context_.CheckStop();
    SetNetworkWeights(poses, context_, &planes_.adjusted);
    RefinementRound round;
    round.planes = static_cast<int>(planes_.adjusted.size());
    round.observations = planes_.observations;
    round.surface_matches = surfaces_.matches;
    Poses start = poses;
    const double cost = PlanarCost(Problem(), poses);
    if (!proposal_.empty() && PlanarCost(Problem(), proposal_) < cost) {
      start = proposal_;
      round.anderson_start = true;
    }
    const PlanarAdjustmentResult adjusted = AdjustPlanes(
        Problem(), start, /*fixed_station=*/0, {.anderson_window = options_.anderson_window});
    round.iterations = adjusted.iterations;
    round.anderson_accepted = adjusted.anderson_accepted;
    round.cost_before = cost;
    round.cost_after = adjusted.final_cost;
    result_.rounds.push_back(round);
    Propose(poses, adjusted.poses);
    return adjusted.poses;
  }

  /// Extrapolates the sequence of the rounds' poses, in the chart about the start poses.
  void Propose(const Poses& from, const Poses& to) {
    if (options_.anderson_window == 0) return;
    const auto coordinates = [&](const Poses& poses) {
      Eigen::VectorXd x(static_cast<Eigen::Index>(6 * poses.size()));
      for (std::size_t s = 0; s < poses.size(); ++s) {
        x.segment<6>(static_cast<Eigen::Index>(6 * s)) =
            LocalDifference(poses[s], input_.survey_from_station[s]);
      }
      return x;
    };
    const Eigen::VectorXd x = accelerator_.Propose(coordinates(from), coordinates(to));
    proposal_.clear();
    for (std::size_t s = 0; s < to.size(); ++s) {
      proposal_.push_back(
          Retract(input_.survey_from_station[s], x.segment<6>(static_cast<Eigen::Index>(6 * s))));
    }
  }

  /// By how much a station's surroundings move.
  double Move(std::size_t s, const RigidTransform& from, const RigidTransform& to) const {
    return (to.translation - from.translation).norm() +
           levers_m_[s] * RotationAngle(to.rotation, from.rotation);
  }

  double LargestMove(const Poses& from, const Poses& to) const {
    double largest = 0.0;
    for (std::size_t s = 0; s < from.size(); ++s) {
      largest = std::max(largest, Move(s, from[s], to[s]));
    }
    return largest;
  }

  /// The station that moved too far to be believed, or -1.
  int MovedTooFar(const Poses& poses) const {
    for (std::size_t s = 1; s < poses.size(); ++s) {
      const RigidTransform& start = input_.survey_from_station[s];
      if (Move(s, start, poses[s]) <= 4.0 * l_) continue;
      const Vector6d xi = LocalDifference(poses[s], start);
      constexpr double kFiveSigma = 25.0;
      if (!(xi.dot(input_.covariance[s].ldlt().solve(xi)) <= kFiveSigma)) {
        return static_cast<int>(s);
      }
    }
    return -1;
  }

  void Judge(const Poses& poses) {
    context_.CheckStop();
    const HeldOutComparison held_out =
        CompareHeldOut(planes_.held_out, input_.survey_from_station, poses);
    result_.held_out = held_out.pairs;
    result_.planes = static_cast<int>(planes_.adjusted.size());
    result_.observations = planes_.observations;
    result_.planes_of_station = planes_.of_station;
    std::vector<WeightedPlane> copy = planes_.adjusted;
    const PlaneWeights weights = SetNetworkWeights(poses, context_, &copy);
    result_.sigma0_m = weights.sigma0_m;
    result_.agreement_factor = weights.agreement_factor;
    PrecisionInput precision_input = Precision(poses);
    precision_input.robust_slope = weights.slope;
    const NetworkPrecision precision = ComputePrecision(
        precision_input,
        {options_.floor_rotation_deg * std::numbers::pi / 180.0, options_.floor_translation_m},
        context_);
    const bool finite =
        precision.valid && std::all_of(poses.begin(), poses.end(),
                                       [](const RigidTransform& pose) { return pose.IsValid(); });
    if (!finite) return KeepStart(Status::kKeptPoseGraph, Reason::kNotFinite);
    result_.variance_factor = precision.variance_factor;
    result_.block_m = precision.block_m;
    result_.weakest = precision.weakest;
    // Half a chi^2: rounding alone may lift the cost above that of an exact start.
    constexpr double kNoCost = 1e-3;
    if (PlanarCost(Problem(), poses) >
        PlanarCost(Problem(), input_.survey_from_station) + kNoCost) {
      return KeepStart(Status::kKeptPoseGraph, Reason::kCostDidNotFall);
    }
    if (const int station = MovedTooFar(poses); station >= 0) {
      result_.station = station;
      return KeepStart(Status::kKeptPoseGraph, Reason::kStationMovedTooFar);
    }
    constexpr double kSignificant = 2.0;
    if (held_out.change.IsWorse(kSignificant)) {
      return KeepStart(Status::kKeptPoseGraph, Reason::kHeldOutPlanesWorse);
    }
    result_.status = Status::kRefined;
    result_.survey_from_station = poses;
    result_.covariance = precision.covariance;
  }

  const NetworkRefinementInput& input_;
  const NetworkRefinementOptions& options_;
  const ExecutionContext& context_;
  std::vector<ClusterList> clusters_;
  double l_ = 0.0;  // voxels' edge
  RigidTransform lattice_from_survey_;
  std::vector<double> levers_m_;  // rms distance of a station's voxels from its instrument
  std::vector<TiltObservation> tilts_;
  std::vector<PoseGraphLink> links_;
  std::vector<PoseGraphLink> all_links_;  // with the surfaces'
  SurfaceObservations surfaces_;
  PlaneSets planes_;
  AndersonAccelerator accelerator_;
  Poses proposal_;
  NetworkRefinementResult result_;
};

}  // namespace

void VisitOptions(OptionVisitor& visitor, NetworkRefinementOptions& options) {
  visitor.Flag("enabled", options.enabled,
               "adjust the planes of all stations at once after the pose graph");
  visitor.Real("root_edge", options.root_edge, "voxels", 2.0, 100.0,
               "edge of the cells that the plane search starts from");
  visitor.Integer("max_rounds", options.max_rounds, "1", 1, 20,
                  "how often planes are associated anew, coarse to fine");
  visitor.Real("max_thickness_m", options.max_thickness_m, "m", 0.001, 0.5,
               "largest standard deviation of a station's points across a plane");
  visitor.Real("max_thinness", options.max_thinness, "1", 0.001, 0.5,
               "largest ratio of a plane's smallest to its middle eigenvalue");
  visitor.Integer("min_planes", options.min_planes, "1", 3, 10000,
                  "with fewer common planes the pose graph's result stands; links whose stations "
                  "share fewer keep their full weight");
  visitor.Real("effective_points", options.effective_points, "1", 1.0, 1e6,
               "cap on the weight of one station's part of a plane, in points");
  visitor.Real("held_out_share", options.held_out_share, "1", 0.0, 0.5,
               "share of the planes that is kept out of the adjustment to check it");
  visitor.Integer("anderson_window", options.anderson_window, "1", 0, 20,
                  "history of the Anderson acceleration; 0 switches it off");
  visitor.Flag("surfaces", options.surfaces,
               "let curved and small surfaces, which no plane covers, take part");
  visitor.Real("floor_rotation_deg", options.floor_rotation_deg, "deg", 0.0, 1.0,
               "systematic rotation error of every station that no redundancy shows");
  visitor.Real("floor_translation_m", options.floor_translation_m, "m", 0.0, 1.0,
               "systematic translation error of every station that no redundancy shows");
}

NetworkRefinementResult RefineNetwork(const NetworkRefinementInput& input,
                                      const NetworkRefinementOptions& options,
                                      const ExecutionContext& context) {
  return Refinement(input, options, context).Run();
}

}  // namespace backsight
