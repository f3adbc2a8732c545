#include "stages/fine_registration.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "graph/planar_adjustment.h"
#include "graph/plane_segmentation.h"
#include "stages/dominant_frame.h"
#include "stages/plane_weights.h"

namespace backsight {
namespace {

/// The clusters that lie within `radius_m` of a structure point, by cells of that size.
std::vector<PointCluster> NearStructures(const StationModel& model,
                                         const RigidTransform& target_from_clusters,
                                         const std::vector<Eigen::Vector3d>& structure_points,
                                         double radius_m) {
  const VoxelLattice lattice{.edge_m = radius_m};
  std::vector<std::uint64_t> active;
  for (const Eigen::Vector3d& point : structure_points) {
    const Eigen::Vector3i cell = lattice.Cell(point);
    for (int i = 0; i < 27; ++i) {
      active.push_back(
          VoxelLattice::Pack(cell + Eigen::Vector3i(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1)));
    }
  }
  std::sort(active.begin(), active.end());
  std::vector<PointCluster> clusters;
  for (const VoxelLeaf& leaf : model.leaves) {
    const std::uint64_t key = lattice.Key(target_from_clusters * leaf.cluster.mean);
    if (std::binary_search(active.begin(), active.end(), key)) clusters.push_back(leaf.cluster);
  }
  return clusters;
}

double Rms(std::span<const WeightedPlane> planes, std::span<const RigidTransform> poses) {
  const std::vector<double> thickness = PlaneThicknesses(planes, poses);
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    for (const PlaneObservation& o : planes[k].observations) {
      sum += o.cluster.count * thickness[k];
      count += o.cluster.count;
    }
  }
  return std::sqrt(sum / count);
}

/// Where the observations lie: the point about which rotations are judged, and their lever arm.
struct Footprint {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< target frame
  double lever_m = 0.1;
};

Footprint FootprintOf(std::span<const WeightedPlane> planes,
                      const RigidTransform& target_from_source) {
  Footprint footprint;
  const auto count = static_cast<double>(planes.size());
  for (const WeightedPlane& plane : planes) {
    footprint.center += plane.observations.back().cluster.mean / count;
  }
  footprint.center = target_from_source * footprint.center;
  double squared = 0.0;
  for (const WeightedPlane& plane : planes) {
    const Eigen::Vector3d mean = target_from_source * plane.observations.back().cluster.mean;
    squared += (mean - footprint.center).squaredNorm() / count;
  }
  footprint.lever_m = std::max(std::sqrt(squared), footprint.lever_m);
  return footprint;
}

/// xi about the origin from balanced parameters about the centre, rotations measured by the shift
/// they cause at the lever arm (docs/stages/fine_registration.md).
Matrix6d Balance(const Footprint& footprint) {
  Matrix6d about = Matrix6d::Identity();
  about.topLeftCorner<3, 3>() /= footprint.lever_m;
  about.bottomLeftCorner<3, 3>() = Skew(footprint.center) / footprint.lever_m;
  return about;
}

constexpr double kWeakSigma = 0.005;  // m: what a project can bear

void JudgeDegeneracy(const Matrix6d& information, const Footprint& footprint, FineResult* result) {
  const Matrix6d about = Balance(footprint);
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(about.transpose() * information * about);
  result->weakest_sigma_m = 1.0 / std::sqrt(std::max(solver.eigenvalues()[0], 1e-12));
  result->weakest_direction = solver.eigenvectors().col(0);
  result->eigenvalue_ratio =
      std::max(solver.eigenvalues()[0], 0.0) / std::max(solver.eigenvalues()[5], 1e-12);
}

/// `more`, but only in the directions that `information` leaves weak: elsewhere both stand on the
/// same surfaces, and counting them twice would be too bold.
Matrix6d InWeakDirections(const Matrix6d& information, const Matrix6d& more,
                          const Footprint& footprint) {
  const Matrix6d about = Balance(footprint);
  const Matrix6d back = about.inverse();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(about.transpose() * information * about);
  Matrix6d weak = Matrix6d::Zero();
  for (int d = 0; d < 6; ++d) {
    const Vector6d axis = solver.eigenvectors().col(d);
    if (solver.eigenvalues()[d] * kWeakSigma * kWeakSigma < 1.0) weak += axis * axis.transpose();
  }
  return back.transpose() * weak * about.transpose() * more * about * weak * back;
}

/// Whether the motion stays within what the coarse result can be wrong.
bool IsNear(const RigidTransform& refined, const RigidTransform& coarse, double resolution_m) {
  constexpr double kLargestTurn = 0.175;
  return refined.IsValid() &&
         (refined.translation - coarse.translation).norm() <= 5.0 * resolution_m &&
         RotationAngle(refined.rotation, coarse.rotation) <= kLargestTurn;
}

/// Planes of a few rounds of association, each from where the last one left the poses.
struct PlaneRounds {
  bool enough = false;
  std::vector<WeightedPlane> planes;
  std::vector<RigidTransform> poses;
  Matrix6d information = Matrix6d::Zero();  ///< with the coarse result's
};

PlaneRounds AdjustOnPlanes(const FineInput& input, const FineOptions& options,
                           const ExecutionContext& context, FineResult* result) {
  const double l = input.target.model.resolution_m();
  std::vector<PointCluster> target_clusters;
  std::vector<PointCluster> source_clusters;
  std::vector<ClusterList> clusters{{input.target.model.leaves, input.target_index.means},
                                    input.source.model.leaves};
  if (options.activation == 1) {
    const double radius_m = options.micro_radius * l;
    target_clusters = NearStructures(input.target.model, {}, input.structure_points, radius_m);
    source_clusters = NearStructures(input.source.model, input.target_from_source,
                                     input.structure_points, radius_m);
    clusters = {target_clusters, source_clusters};
  }
  const std::vector<PosePrior> priors{{1, input.target_from_source, input.information}};
  // Cells along the walls hold whole walls; cells across them hold corners, which pull on planes.
  const RigidTransform lattice{FindDominantFrame(input.target.normals).frame_from_cloud,
                               Eigen::Vector3d::Zero()};
  PlaneRounds rounds;
  rounds.poses = {RigidTransform{}, input.target_from_source};
  for (int round = 0; round < options.rounds; ++round) {
    context.CheckStop();
    const double tolerance = std::pow(0.5, round);
    PlaneSearchOptions search;
    search.root_edge_m = options.root_edge * l;
    search.max_thickness_m = options.max_thickness_m;
    search.max_thinness = options.max_thinness;
    search.max_angle_rad = std::max(0.175 * tolerance, 0.05);
    search.max_offset_m = std::max(l * tolerance, 0.03);
    rounds.planes.clear();
    const std::vector<RigidTransform> lattice_poses{lattice, lattice * rounds.poses[1]};
    for (PlaneAssociation& plane : FindPlanes(clusters, lattice_poses, search)) {
      for (PlaneObservation& o : plane.observations) CapCount(options.effective_points, &o.cluster);
      rounds.planes.push_back({std::move(plane.observations), 1.0});
    }
    result->planes = static_cast<int>(rounds.planes.size());
    if (result->planes < options.min_planes) return rounds;
    SetNetworkWeights(rounds.poses, context, &rounds.planes);
    PlanarAdjustmentOptions adjustment;
    adjustment.anderson_window = options.anderson_window;
    // Planes are sought anew from where all but the last end: these need not be exact.
    if (round + 1 < options.rounds) adjustment.relative_decrease = 1e-4;
    const PlanarAdjustmentResult adjusted =
        AdjustPlanes(rounds.planes, priors, rounds.poses, /*fixed_station=*/0, adjustment);
    rounds.poses = adjusted.poses;
    rounds.information = adjusted.information.bottomRightCorner<6, 6>();
    result->iterations += adjusted.iterations;
    result->anderson_accepted += adjusted.anderson_accepted;
  }
  rounds.enough = true;
  return rounds;
}

/// Lets pairs of voxels, each with its own covariance, determine what planes leave open.
void RefineWhereWeak(const FineInput& input, const PlaneRounds& rounds, FineResult* result) {
  SurfaceRefinementOptions surface_options;
  surface_options.covariance = SurfaceRefinementOptions::Covariance::kCluster;
  const RigidTransform start = rounds.enough ? rounds.poses[1] : input.target_from_source;
  const Matrix6d prior = rounds.enough ? rounds.information : input.information;
  const SurfaceRefinement surfaces = RefineOnSurfaces(
      input.source, input.target, input.target_index, start, prior, surface_options);
  if (surfaces.information.isZero()) return;
  if (!IsNear(surfaces.target_from_source, input.target_from_source,
              input.target.model.resolution_m())) {
    result->status = FineResult::Status::kDiverged;
    result->target_from_source = input.target_from_source;
    result->information = input.information;
    return;
  }
  const Footprint footprint = rounds.enough
                                  ? FootprintOf(rounds.planes, surfaces.target_from_source)
                                  : Footprint{surfaces.center, std::max(surfaces.spread_m, 0.1)};
  const Matrix6d known = prior - input.information;  // without the coarse result
  const Matrix6d added = InWeakDirections(known, surfaces.information, footprint);
  result->target_from_source = surfaces.target_from_source;
  result->information = prior + added;
  result->surface_matches = surfaces.matches;
  JudgeDegeneracy(known + added, footprint, result);
  result->status = result->weakest_sigma_m <= kWeakSigma ? FineResult::Status::kRefinedOnSurfaces
                                                         : FineResult::Status::kWeak;
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, FineOptions& options) {
  visitor.Choice("activation", options.activation, {"overlap", "micro"},
                 "where planes are sought: all over the overlap, or only near the corresponding "
                 "micro-structures");
  visitor.Real("root_edge", options.root_edge, "voxels", 2.0, 100.0,
               "edge of the cells that the plane search starts from");
  visitor.Real("micro_radius", options.micro_radius, "voxels", 1.0, 100.0,
               "distance from a micro-structure within which planes are sought (micro)");
  visitor.Integer("rounds", options.rounds, "1", 1, 10,
                  "how often planes are associated anew, coarse to fine");
  visitor.Real("max_thickness_m", options.max_thickness_m, "m", 0.001, 0.5,
               "largest standard deviation of a station's points across a plane");
  visitor.Real("max_thinness", options.max_thinness, "1", 0.001, 0.5,
               "largest ratio of a plane's smallest to its middle eigenvalue");
  visitor.Integer("min_planes", options.min_planes, "1", 3, 10000,
                  "with fewer common planes the coarse transform stands");
  visitor.Real("effective_points", options.effective_points, "1", 1.0, 1e6,
               "cap on the weight of one station's part of a plane, in points");
  visitor.Integer("anderson_window", options.anderson_window, "1", 0, 20,
                  "history of the Anderson acceleration; 0 switches it off");
  visitor.Flag("surfaces", options.surfaces,
               "let curved and small surfaces, which no plane covers, take part at the end");
}

FineResult RefinePair(const FineInput& input, const FineOptions& options,
                      const ExecutionContext& context) {
  FineResult result;
  result.target_from_source = input.target_from_source;
  result.information = input.information;
  const PlaneRounds rounds = AdjustOnPlanes(input, options, context, &result);
  if (!rounds.enough) {
    if (options.surfaces) RefineWhereWeak(input, rounds, &result);
    return result;
  }
  result.rms_m = Rms(rounds.planes, rounds.poses);
  RigidTransform refined = rounds.poses[1];
  if (options.surfaces) {
    SurfaceRefinementOptions surface_options;
    surface_options.normal_sigma_m = std::max(0.5 * result.rms_m, 0.001);
    refined = RefineOnSurfaces(input.source, input.target, input.target_index, refined,
                               rounds.information, surface_options)
                  .target_from_source;
  }
  if (!rounds.information.allFinite() ||
      !IsNear(refined, input.target_from_source, input.target.model.resolution_m())) {
    result.status = FineResult::Status::kDiverged;
    return result;
  }
  result.target_from_source = refined;
  result.information = rounds.information;
  JudgeDegeneracy(rounds.information - input.information, FootprintOf(rounds.planes, refined),
                  &result);
  result.status = FineResult::Status::kRefined;
  if (result.weakest_sigma_m > kWeakSigma) {
    result.status = FineResult::Status::kWeak;
    if (options.surfaces) RefineWhereWeak(input, rounds, &result);
  }
  return result;
}

}  // namespace backsight
