#include "graph/planar_statistics.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>

namespace backsight {
namespace {

double SmallestEigenvalue(const Eigen::Matrix3d& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix, Eigen::EigenvaluesOnly);
  return std::max(solver.eigenvalues()[0], 0.0);
}

/// What one block adds to the two sums.
struct BlockSums {
  double pull = 0.0;
  double expected = 0.0;
};

/// Sums of a block over the stations that see it.
BlockSums SumBlock(std::span<const WeightedPlane> planes, std::span<const std::size_t> members,
                   std::span<const RigidTransform> poses, const Eigen::MatrixXd& covariance) {
  std::vector<int> stations;
  std::vector<PlaneTerms> terms;
  for (const std::size_t k : members) {
    terms.push_back(ComputePlaneTerms(planes[k], poses));
    for (const PlaneTerms::Part& part : terms.back().parts) stations.push_back(part.station);
  }
  std::sort(stations.begin(), stations.end());
  stations.erase(std::unique(stations.begin(), stations.end()), stations.end());
  const auto row_of = [&](int station) {
    return 6 * (std::lower_bound(stations.begin(), stations.end(), station) - stations.begin());
  };

  const auto rows = static_cast<Eigen::Index>(6 * stations.size());
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(rows);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(rows, rows);
  for (const PlaneTerms& plane : terms) {
    for (const PlaneTerms::Part& a : plane.parts) {
      const Eigen::Index i = row_of(a.station);
      gradient.segment<6>(i) += a.gradient;
      matrix.block<6, 6>(i, i) += a.held;
      for (const PlaneTerms::Part& b : plane.parts) {
        matrix.block<6, 6>(i, row_of(b.station)).noalias() -= a.coupling * b.coupling.transpose();
      }
    }
  }
  Eigen::MatrixXd local(rows, rows);
  for (std::size_t a = 0; a < stations.size(); ++a) {
    for (std::size_t b = 0; b < stations.size(); ++b) {
      local.block<6, 6>(static_cast<Eigen::Index>(6 * a), static_cast<Eigen::Index>(6 * b)) =
          covariance.block<6, 6>(6 * stations[a], 6 * stations[b]);
    }
  }
  const Eigen::MatrixXd share = local * matrix;
  BlockSums sums;
  sums.pull = gradient.dot(local * gradient);
  sums.expected = share.trace() - share.cwiseProduct(share.transpose()).sum();
  return sums;
}

}  // namespace

PlaneAgreement Agreement(const WeightedPlane& plane, std::span<const RigidTransform> poses) {
  PlaneAgreement agreement;
  PointCluster joint;
  double own = 0.0;
  for (const PlaneObservation& o : plane.observations) {
    const RigidTransform& pose = poses[static_cast<std::size_t>(o.station)];
    joint += Transformed(pose.rotation, pose.translation, o.cluster);
    own += SmallestEigenvalue(o.cluster.scatter);
  }
  agreement.own_thickness_m2 = own / joint.count;
  agreement.excess_m2 = std::max(SmallestEigenvalue(joint.scatter) - own, 0.0);
  agreement.freedom = 3 * (static_cast<int>(plane.observations.size()) - 1);
  return agreement;
}

VarianceFactor EstimateVarianceFactor(std::span<const WeightedPlane> planes,
                                      std::span<const std::uint64_t> block,
                                      std::span<const RigidTransform> poses,
                                      const Eigen::MatrixXd& covariance,
                                      const ExecutionContext& context) {
  std::vector<std::size_t> order(planes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return block[a] < block[b]; });
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || block[order[i]] != block[order[i - 1]]) begins.push_back(i);
  }
  begins.push_back(order.size());

  std::vector<BlockSums> sums(begins.size() - 1);
  context.ParallelFor(sums.size(), [&](std::size_t b) {
    const auto members = std::span(order).subspan(begins[b], begins[b + 1] - begins[b]);
    sums[b] = SumBlock(planes, members, poses, covariance);
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
