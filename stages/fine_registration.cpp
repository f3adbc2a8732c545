#include "stages/fine_registration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "graph/planar_adjustment.h"
#include "graph/plane_segmentation.h"

namespace backsight {
namespace {

std::vector<PointCluster> Clusters(const StationModel& model) {
  std::vector<PointCluster> clusters;
  clusters.reserve(model.leaves.size());
  for (const VoxelLeaf& leaf : model.leaves) clusters.push_back(leaf.cluster);
  return clusters;
}

/// Keeps what lies within `radius_m` of a structure point, by cells of that size.
std::vector<PointCluster> NearStructures(std::vector<PointCluster> clusters,
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
  std::erase_if(clusters, [&](const PointCluster& cluster) {
    return !std::binary_search(active.begin(), active.end(),
                               lattice.Key(target_from_clusters * cluster.mean));
  });
  return clusters;
}

/// A dense cluster tells no more than `cap` points would: its errors are not independent.
void CapCount(double cap, PointCluster* cluster) {
  if (cluster->count <= cap) return;
  cluster->scatter *= cap / cluster->count;
  cluster->count = cap;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Maximum-likelihood weights n / (2 sigma^2), sigma from the planes' own thickness, times a robust
/// factor that takes thick planes out.
void SetWeights(std::span<const RigidTransform> poses, std::vector<WeightedPlane>* planes) {
  const std::vector<double> thickness = PlaneThicknesses(*planes, poses);
  constexpr double kFloor = 0.001 * 0.001;  // m^2: no plane is better than a millimetre
  constexpr double kThick = 100.0;          // only planes ten times as thick as most lose weight
  const double variance = std::max(Median(thickness), kFloor);
  for (std::size_t k = 0; k < planes->size(); ++k) {
    double count = 0.0;
    for (const PlaneObservation& o : (*planes)[k].observations) count += o.cluster.count;
    const double robust = 1.0 / (1.0 + thickness[k] / (kThick * variance));
    (*planes)[k].weight = count / (2.0 * variance) * robust * robust;
  }
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

/// The least determined direction, rotations measured by the shift they cause at the planes' rms
/// distance from their centre (docs/stages/fine_registration.md).
void JudgeDegeneracy(std::span<const WeightedPlane> planes,
                     const RigidTransform& target_from_source, const Matrix6d& information,
                     FineResult* result) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const WeightedPlane& plane : planes) center += plane.observations.back().cluster.mean;
  center = target_from_source * Eigen::Vector3d(center / static_cast<double>(planes.size()));
  double squared = 0.0;
  for (const WeightedPlane& plane : planes) {
    squared += (target_from_source * plane.observations.back().cluster.mean - center).squaredNorm();
  }
  const double lever_m = std::max(std::sqrt(squared / static_cast<double>(planes.size())), 0.1);

  // xi about the origin from balanced parameters about the centre.
  Matrix6d about = Matrix6d::Identity();
  about.topLeftCorner<3, 3>() /= lever_m;
  about.bottomLeftCorner<3, 3>() = Skew(center) / lever_m;
  const Matrix6d balanced = about.transpose() * information * about;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(balanced);
  result->weakest_sigma_m = 1.0 / std::sqrt(std::max(solver.eigenvalues()[0], 1e-12));
  result->weakest_direction = solver.eigenvectors().col(0);
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
  const double l = input.target.model.resolution_m();
  std::vector<PointCluster> target_clusters = Clusters(input.target.model);
  std::vector<PointCluster> source_clusters = Clusters(input.source.model);
  if (options.activation == 1) {
    const double radius_m = options.micro_radius * l;
    target_clusters =
        NearStructures(std::move(target_clusters), {}, input.structure_points, radius_m);
    source_clusters = NearStructures(std::move(source_clusters), input.target_from_source,
                                     input.structure_points, radius_m);
  }
  const std::vector<const std::vector<PointCluster>*> clusters{&target_clusters, &source_clusters};
  const std::vector<PosePrior> priors{{1, input.target_from_source, input.information}};

  FineResult result;
  result.target_from_source = input.target_from_source;
  result.information = input.information;
  std::vector<RigidTransform> poses{RigidTransform{}, input.target_from_source};
  std::vector<WeightedPlane> planes;
  PlanarAdjustmentResult adjusted;
  for (int round = 0; round < options.rounds; ++round) {
    context.CheckStop();
    const double tolerance = std::pow(0.5, round);
    PlaneSearchOptions search;
    search.root_edge_m = options.root_edge * l;
    search.max_thickness_m = options.max_thickness_m;
    search.max_thinness = options.max_thinness;
    search.max_angle_rad = std::max(0.175 * tolerance, 0.05);
    search.max_offset_m = std::max(l * tolerance, 0.03);
    planes.clear();
    for (PlaneAssociation& plane : FindPlanes(clusters, poses, search)) {
      for (PlaneObservation& o : plane.observations) CapCount(options.effective_points, &o.cluster);
      planes.push_back({std::move(plane.observations), 1.0});
    }
    result.planes = static_cast<int>(planes.size());
    if (result.planes < options.min_planes) return result;
    SetWeights(poses, &planes);
    adjusted = AdjustPlanes(planes, priors, poses, /*fixed_station=*/0,
                            {.anderson_window = options.anderson_window});
    poses = adjusted.poses;
    result.iterations += adjusted.iterations;
    result.anderson_accepted += adjusted.anderson_accepted;
  }

  result.rms_m = Rms(planes, poses);
  RigidTransform refined = poses[1];
  const Matrix6d information = adjusted.information.bottomRightCorner<6, 6>();
  if (options.surfaces) {
    refined = RefineOnSurfaces(input.source, input.target, refined, information,
                               std::max(0.5 * result.rms_m, 0.001))
                  .target_from_source;
  }
  const double shift =
      (refined * Eigen::Vector3d::Zero() - input.target_from_source * Eigen::Vector3d::Zero())
          .norm();
  constexpr double kLargestTurn = 0.175;
  if (!refined.IsValid() || !information.allFinite() || shift > 5.0 * l ||
      RotationAngle(refined.rotation, input.target_from_source.rotation) > kLargestTurn) {
    result.status = FineResult::Status::kDiverged;
    return result;
  }
  result.target_from_source = refined;
  result.information = information;
  JudgeDegeneracy(planes, refined, result.information - input.information, &result);
  constexpr double kWeakSigma = 0.005;
  result.status = result.weakest_sigma_m <= kWeakSigma ? FineResult::Status::kRefined
                                                       : FineResult::Status::kWeak;
  return result;
}

}  // namespace backsight
