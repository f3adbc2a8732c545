#include "stages/fine_registration.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "stages/cluster_refinement.h"
#include "stages/open_translations.h"
#include "stages/plane_rounds.h"
#include "stages/surface_choice.h"
#include "stages/surface_refinement.h"

namespace backsight {
namespace {

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
  Footprint footprint{.center = target_from_source * CenterOf(planes)};
  const auto count = static_cast<double>(planes.size());
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
constexpr double kOpenSigma = 100.0;  // m: of what nothing holds

void JudgeDegeneracy(const Matrix6d& information, const Footprint& footprint, FineResult* result) {
  const Matrix6d about = Balance(footprint);
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(about.transpose() * information * about);
  result->weakest_sigma_m =
      std::min(1.0 / std::sqrt(std::max(solver.eigenvalues()[0], 1e-12)), kOpenSigma);
  result->weakest_direction = solver.eigenvectors().col(0);
  result->eigenvalue_ratio =
      std::max(solver.eigenvalues()[0], 0.0) / std::max(solver.eigenvalues()[5], 1e-12);
}

/// Whether the motion stays within what the coarse result can be wrong.
bool IsNear(const RigidTransform& refined, const RigidTransform& coarse, double resolution_m) {
  constexpr double kLargestTurn = 0.175;
  return refined.IsValid() &&
         (refined.translation - coarse.translation).norm() <= 5.0 * resolution_m &&
         RotationAngle(refined.rotation, coarse.rotation) <= kLargestTurn;
}

/// Lets surfaces that no plane covers have their say beside the planes, but of what these leave
/// open: normals have errors, too.
RigidTransform RefineBesidePlanes(const FineInput& input, const PlaneRounds& rounds,
                                  double planes_rms_m) {
  const double normal_sigma_m = std::max(0.5 * planes_rms_m, 0.001);
  std::vector<std::uint32_t> of_this_pair;
  if (input.source_surfaces == nullptr) {
    of_this_pair = ChooseSurfaces(input.source.normals, kRefinedSurfaces);
  }
  const RigidTransform& start = rounds.poses[1];
  const Matrix6d information = rounds.of_planes + input.information;
  const RigidTransform refined = RefineOnSurfaces(
      input.source, input.source_surfaces != nullptr ? *input.source_surfaces : of_this_pair,
      input.target, input.target_index, start, information, normal_sigma_m);
  return HoldTranslations(rounds.open, CenterOf(rounds.planes), start, information, refined);
}

/// Lets pairs of voxels, each with its own covariance, stand in for planes.
void RefineWithoutPlanes(const FineInput& input, FineResult* result) {
  const ClusterRefinement voxels = RefineOnClusters(input.source, input.target, input.target_index,
                                                    input.target_from_source, input.information);
  if (voxels.information.isZero()) return;
  if (!IsNear(voxels.target_from_source, input.target_from_source,
              input.target.model.resolution_m())) {
    result->status = FineResult::Status::kDiverged;
    return;
  }
  result->target_from_source = voxels.target_from_source;
  result->information = input.information + voxels.information;
  result->surface_matches = voxels.matches;
  JudgeDegeneracy(voxels.information, {voxels.center, std::max(voxels.spread_m, 0.1)}, result);
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
    if (options.surfaces) RefineWithoutPlanes(input, &result);
    return result;
  }
  result.rms_m = Rms(rounds.planes, rounds.poses);
  RigidTransform refined = rounds.poses[1];
  if (options.surfaces) refined = RefineBesidePlanes(input, rounds, result.rms_m);
  if (!rounds.of_planes.allFinite() ||
      !IsNear(refined, input.target_from_source, input.target.model.resolution_m())) {
    result.status = FineResult::Status::kDiverged;
    return result;
  }
  result.target_from_source = refined;
  result.information = rounds.of_planes + input.information;
  JudgeDegeneracy(rounds.of_planes, FootprintOf(rounds.planes, refined), &result);
  result.status = result.weakest_sigma_m <= kWeakSigma ? FineResult::Status::kRefined
                                                       : FineResult::Status::kWeak;
  return result;
}

}  // namespace backsight
