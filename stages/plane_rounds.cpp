#include "stages/plane_rounds.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "graph/pair_planes.h"
#include "graph/planar_adjustment.h"
#include "stages/dominant_frame.h"
#include "stages/open_translations.h"
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
  for (std::size_t i = 0; i < model.leaves.size(); ++i) {
    const std::uint64_t key = lattice.Key(target_from_clusters * model.leaves.Mean(i));
    if (!std::binary_search(active.begin(), active.end(), key)) continue;
    clusters.push_back(model.leaves.Cluster(i));
  }
  return clusters;
}

/// What planes must be like in a round of association.
PlaneSearchOptions SearchOptions(const FineOptions& options, double resolution_m, int round) {
  PlaneSearchOptions search;
  search.root_edge_m = options.root_edge * resolution_m;
  search.max_thickness_m = options.max_thickness_m;
  search.max_thinness = options.max_thinness;
  NarrowTolerances(resolution_m, round, &search);
  return search;
}

PlaneTree MakeTree(const Surface& target, const ClusterList& clusters, const FineOptions& options) {
  // Cells along the walls hold whole walls; cells across them hold corners, which pull on planes.
  const RigidTransform lattice{FindDominantFrame(target.normals).frame_from_cloud,
                               Eigen::Vector3d::Zero()};
  return {clusters, lattice, SearchOptions(options, target.model.resolution_m(), 0)};
}

/// Both stations' clusters as the search for planes wants them.
class PlaneSources {
 public:
  PlaneSources(const FineInput& input, const FineOptions& options) : input_(input) {
    const bool is_micro = options.activation == 1;
    if (is_micro) {
      const double radius_m = options.micro_radius * input.target.model.resolution_m();
      target_ = NearStructures(input.target.model, {}, input.structure_points, radius_m);
      source_ = NearStructures(input.source.model, input.target_from_source, input.structure_points,
                               radius_m);
      tree_ = MakeTree(input.target, target_, options);
    } else if (input.target_planes == nullptr) {
      tree_ = MakePlaneTree(input.target, options);
    }
    is_micro_ = is_micro;
  }
  const PlaneTree& Target() const { return tree_ ? *tree_ : *input_.target_planes; }
  ClusterList Source() const {
    return is_micro_ ? ClusterList(source_) : ClusterList(input_.source.model.leaves);
  }

 private:
  const FineInput& input_;
  bool is_micro_ = false;
  std::vector<PointCluster> target_, source_;
  std::optional<PlaneTree> tree_;
};

// What planes seem to know of a translation over what their errors make of it.
constexpr double kOpenRatio = 2.0;
constexpr double kClearRatio = 20.0;  // so clear in the first round that no other need be asked

bool MayBeOpen(const PlaneRounds& rounds) {
  return OpenTranslations(rounds.planes, rounds.poses, kClearRatio).cols() > 0;
}

/// What the planes alone know where an adjustment has ended, whose matrix holds the coarse result's
/// information as it is there.
Matrix6d OfPlanes(const FineInput& input, const RigidTransform& adjusted,
                  const Matrix6d& information) {
  const Matrix6d jacobian =
      LocalDifferenceJacobian(LocalDifference(adjusted, input.target_from_source));
  return information - jacobian.transpose() * input.information * jacobian;
}

}  // namespace

Eigen::Vector3d CenterOf(std::span<const WeightedPlane> planes) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const WeightedPlane& plane : planes) center += plane.observations.back().cluster.mean;
  return center / static_cast<double>(planes.size());
}

PlaneTree MakePlaneTree(const Surface& target, const FineOptions& options) {
  return MakeTree(target, target.model.leaves, options);
}

PlaneRounds AdjustOnPlanes(const FineInput& input, const FineOptions& options,
                           const ExecutionContext& context, FineResult* result) {
  const double l = input.target.model.resolution_m();
  const PlaneSources sources(input, options);
  const RigidTransform lattice = sources.Target().lattice_from_station();
  PairPlaneSearch planes(sources.Target(), sources.Source());
  const std::vector<PosePrior> priors{{1, input.target_from_source, input.information}};
  bool may_be_open = true;
  PlaneRounds rounds;
  rounds.poses = {RigidTransform{}, input.target_from_source};
  for (int round = 0; round < options.rounds; ++round) {
    context.CheckStop();
    rounds.planes.clear();
    for (PlaneAssociation& plane :
         planes.Find(lattice * rounds.poses[1], SearchOptions(options, l, round))) {
      for (PlaneObservation& o : plane.observations) CapCount(options.effective_points, &o.cluster);
      rounds.planes.push_back({std::move(plane.observations), 1.0});
    }
    result->planes = static_cast<int>(rounds.planes.size());
    if (result->planes < options.min_planes) return rounds;
    SetNetworkWeights(rounds.poses, context, &rounds.planes);
    if (round == 0) may_be_open = MayBeOpen(rounds);
    if (may_be_open) rounds.open = OpenTranslations(rounds.planes, rounds.poses, kOpenRatio);
    PlanarAdjustmentOptions adjustment;
    adjustment.anderson_window = options.anderson_window;
    // Planes are sought anew from where all but the last end: these need not be exact.
    if (round + 1 < options.rounds) adjustment.relative_decrease = 1e-4;
    const PlanarAdjustmentResult adjusted =
        AdjustPlanes(rounds.planes, priors, rounds.poses, /*fixed_station=*/0, adjustment);
    const Matrix6d information = adjusted.information.bottomRightCorner<6, 6>();
    rounds.poses[1] = HoldTranslations(rounds.open, CenterOf(rounds.planes),
                                       input.target_from_source, information, adjusted.poses[1]);
    rounds.of_planes =
        WithoutTranslations(rounds.open, OfPlanes(input, adjusted.poses[1], information));
    result->iterations += adjusted.iterations;
    result->anderson_accepted += adjusted.anderson_accepted;
  }
  rounds.enough = true;
  return rounds;
}

}  // namespace backsight
