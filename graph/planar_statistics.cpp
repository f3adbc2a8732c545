#include "graph/planar_statistics.h"

#include <algorithm>
#include <vector>

#include "graph/plane_fit.h"

namespace backsight {
namespace {

/// What one block adds to the two sums.
struct BlockSums {
  double pull = 0.0;
  double expected = 0.0;
};

BlockSums SumsOf(const BlockEquations& block, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd local = block.Part(covariance);
  const Eigen::MatrixXd share = local * block.matrix;
  return {block.gradient.dot(local * block.gradient),
          share.trace() - share.cwiseProduct(share.transpose()).sum()};
}

}  // namespace

PlaneAgreement Agreement(const WeightedPlane& plane, std::span<const RigidTransform> poses) {
  std::vector<PointCluster> clusters{JointCluster(plane, poses)};  // then every station's own
  for (const PlaneObservation& o : plane.observations) clusters.push_back(o.cluster);
  std::vector<PlaneFit> fits(clusters.size());
  FitPlanes(clusters, /*normals=*/false, fits);
  const auto squares = [&](std::size_t i) {
    return std::max(fits[i].eigenvalues[0], 0.0) * clusters[i].count;
  };
  double own = 0.0;
  for (std::size_t i = 1; i < clusters.size(); ++i) own += squares(i);
  PlaneAgreement agreement;
  agreement.own_thickness_m2 = own / clusters.front().count;
  agreement.excess_m2 = std::max(squares(0) - own, 0.0);
  agreement.freedom = 3 * (static_cast<int>(plane.observations.size()) - 1);
  return agreement;
}

VarianceFactor EstimateVarianceFactor(const BlockMembers& members,
                                      std::span<const RigidTransform> poses,
                                      const Eigen::MatrixXd& covariance,
                                      const ExecutionContext& context) {
  const BlockList blocks(members.block);
  std::vector<BlockSums> sums(blocks.size());
  context.ParallelFor(sums.size(), [&](std::size_t b) {
    const BlockEquations sum =
        SumBlock(members, blocks[b], poses, PlaneCurvature::kGaussNewton, /*slope=*/1.0);
    sums[b] = SumsOf(sum, covariance);
  });
  double pull = 0.0;
  double expected = 0.0;
  double squared = 0.0;
  for (const BlockSums& s : sums) {
    pull += s.pull;
    expected += s.expected;
    squared += s.expected * s.expected;
  }
  VarianceFactor result;
  if (!(expected > 0.0)) return result;
  result.factor = pull / expected;
  result.effective_blocks = expected * expected / squared;
  return result;
}

}  // namespace backsight
