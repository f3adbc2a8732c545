#include "graph/planar_statistics.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "graph/plane_fit.h"

namespace backsight {
namespace {

/// What one block adds to the two sums.
struct BlockSums {
  double pull = 0.0;
  double expected = 0.0;
};

/// Normal equations of a block, only of the stations that take part in it.
class Block {
 public:
  explicit Block(std::vector<int> stations) : stations_(std::move(stations)) {
    std::sort(stations_.begin(), stations_.end());
    stations_.erase(std::unique(stations_.begin(), stations_.end()), stations_.end());
    const auto rows = static_cast<Eigen::Index>(6 * stations_.size());
    gradient_ = Eigen::VectorXd::Zero(rows);
    matrix_ = Eigen::MatrixXd::Zero(rows, rows);
  }

  void Add(const PlaneTerms& plane) {
    for (const PlaneTerms::Part& a : plane.parts) {
      const Eigen::Index i = RowOf(a.station);
      gradient_.segment<6>(i) += a.gradient;
      matrix_.block<6, 6>(i, i) += a.held;
      for (const PlaneTerms::Part& b : plane.parts) {
        matrix_.block<6, 6>(i, RowOf(b.station)).noalias() -= a.coupling * b.coupling.transpose();
      }
    }
  }

  void Add(const LinkScore& score) {
    const Eigen::Index i = RowOf(score.source);
    const Eigen::Index j = RowOf(score.target);
    gradient_.segment<6>(i) += score.gradient;
    gradient_.segment<6>(j) -= score.gradient;
    matrix_.block<6, 6>(i, i) += score.matrix;
    matrix_.block<6, 6>(j, j) += score.matrix;
    matrix_.block<6, 6>(i, j) -= score.matrix;
    matrix_.block<6, 6>(j, i) -= score.matrix;
  }

  BlockSums Sums(const Eigen::MatrixXd& covariance) const {
    Eigen::MatrixXd local(matrix_.rows(), matrix_.cols());
    for (std::size_t a = 0; a < stations_.size(); ++a) {
      for (std::size_t b = 0; b < stations_.size(); ++b) {
        local.block<6, 6>(static_cast<Eigen::Index>(6 * a), static_cast<Eigen::Index>(6 * b)) =
            covariance.block<6, 6>(6 * stations_[a], 6 * stations_[b]);
      }
    }
    const Eigen::MatrixXd share = local * matrix_;
    return {gradient_.dot(local * gradient_),
            share.trace() - share.cwiseProduct(share.transpose()).sum()};
  }

 private:
  Eigen::Index RowOf(int station) const {
    return 6 * (std::lower_bound(stations_.begin(), stations_.end(), station) - stations_.begin());
  }

  std::vector<int> stations_;
  Eigen::VectorXd gradient_;
  Eigen::MatrixXd matrix_;
};

/// `members` below the number of planes are planes, the others scores.
BlockSums SumBlock(std::span<const WeightedPlane> planes, std::span<const LinkScore> scores,
                   std::span<const std::size_t> members, std::span<const RigidTransform> poses,
                   const Eigen::MatrixXd& covariance) {
  std::vector<int> stations;
  for (const std::size_t k : members) {
    if (k < planes.size()) {
      for (const PlaneObservation& o : planes[k].observations) stations.push_back(o.station);
    } else {
      const LinkScore& score = scores[k - planes.size()];
      stations.insert(stations.end(), {score.source, score.target});
    }
  }
  Block block(std::move(stations));
  for (const std::size_t k : members) {
    if (k < planes.size()) {
      block.Add(ComputePlaneTerms(planes[k], poses));
    } else {
      block.Add(scores[k - planes.size()]);
    }
  }
  return block.Sums(covariance);
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

VarianceFactor EstimateVarianceFactor(std::span<const WeightedPlane> planes,
                                      std::span<const LinkScore> scores,
                                      std::span<const std::uint64_t> block,
                                      std::span<const RigidTransform> poses,
                                      const Eigen::MatrixXd& covariance,
                                      const ExecutionContext& context) {
  std::vector<std::size_t> order(planes.size() + scores.size());
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
    sums[b] = SumBlock(planes, scores, members, poses, covariance);
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
