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

/// A station whose responses are looked at.
struct Witness {
  int station = 0;
  Matrix6d from_perturbation;  ///< to turn and shift of the instrument
  double turn_variance = 1.0;
  double shift_variance = 1.0;
};

std::vector<Witness> ChooseWitnesses(std::span<const RigidTransform> poses,
                                     const Eigen::MatrixXd& covariance) {
  constexpr std::size_t kMost = 24;
  const std::size_t stride = poses.size() / kMost + 1;
  std::vector<Witness> witnesses;
  for (std::size_t s = 1; s < poses.size(); s += stride) {
    Witness witness;
    witness.station = static_cast<int>(s);
    witness.from_perturbation.setIdentity();
    witness.from_perturbation.bottomLeftCorner<3, 3>() = -Skew(poses[s].translation);
    const auto row = static_cast<Eigen::Index>(6 * s);
    const Matrix6d formal = witness.from_perturbation * covariance.block<6, 6>(row, row) *
                            witness.from_perturbation.transpose();
    witness.turn_variance = formal.topLeftCorner<3, 3>().trace();
    witness.shift_variance = formal.bottomRightCorner<3, 3>().trace();
    if (witness.turn_variance > 0.0 && witness.shift_variance > 0.0) witnesses.push_back(witness);
  }
  return witnesses;
}

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
    const Eigen::MatrixXd own = Own(covariance);
    const Eigen::MatrixXd share = own * matrix_;
    return {gradient_.dot(own * gradient_),
            share.trace() - share.cwiseProduct(share.transpose()).sum()};
  }

  ResponseScatter Responses(std::span<const Witness> witnesses,
                            const Eigen::MatrixXd& covariance) const {
    const Eigen::MatrixXd left = matrix_ - matrix_ * Own(covariance) * matrix_;
    ResponseScatter sum;
    for (const Witness& witness : witnesses) {
      const Eigen::MatrixXd response =
          witness.from_perturbation * Rows(witness.station, covariance);
      const Vector6d found = response * gradient_;
      const Matrix6d expected = response * left * response.transpose();
      const Eigen::Vector3d turn = found.head<3>();
      const Eigen::Vector3d shift = found.tail<3>();
      sum.turn_found += turn * turn.transpose() / witness.turn_variance;
      sum.turn_expected += expected.topLeftCorner<3, 3>() / witness.turn_variance;
      sum.shift_found += shift * shift.transpose() / witness.shift_variance;
      sum.shift_expected += expected.bottomRightCorner<3, 3>() / witness.shift_variance;
    }
    return sum;
  }

 private:
  /// Covariance between a station and those of the block, and among those of the block.
  Eigen::MatrixXd Rows(int station, const Eigen::MatrixXd& covariance) const {
    Eigen::MatrixXd rows(6, matrix_.cols());
    for (std::size_t b = 0; b < stations_.size(); ++b) {
      rows.middleCols<6>(static_cast<Eigen::Index>(6 * b)) =
          covariance.block<6, 6>(6 * station, 6 * stations_[b]);
    }
    return rows;
  }
  Eigen::MatrixXd Own(const Eigen::MatrixXd& covariance) const {
    Eigen::MatrixXd own(matrix_.rows(), matrix_.cols());
    for (std::size_t a = 0; a < stations_.size(); ++a) {
      own.middleRows<6>(static_cast<Eigen::Index>(6 * a)) = Rows(stations_[a], covariance);
    }
    return own;
  }

  Eigen::Index RowOf(int station) const {
    return 6 * (std::lower_bound(stations_.begin(), stations_.end(), station) - stations_.begin());
  }

  std::vector<int> stations_;
  Eigen::VectorXd gradient_;
  Eigen::MatrixXd matrix_;
};

/// Planes and scores gathered in blocks.
class Blocks {
 public:
  Blocks(std::span<const WeightedPlane> planes, std::span<const LinkScore> scores,
         std::span<const std::uint64_t> block, std::span<const RigidTransform> poses)
      : planes_(planes), scores_(scores), poses_(poses), order_(planes.size() + scores.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::stable_sort(order_.begin(), order_.end(),
                     [&](std::size_t a, std::size_t b) { return block[a] < block[b]; });
    for (std::size_t i = 0; i < order_.size(); ++i) {
      if (i == 0 || block[order_[i]] != block[order_[i - 1]]) begins_.push_back(i);
    }
    begins_.push_back(order_.size());
  }

  std::size_t size() const { return begins_.size() - 1; }

  Block Make(std::size_t b) const {
    std::vector<int> stations;
    for (std::size_t i = begins_[b]; i < begins_[b + 1]; ++i) {
      const std::size_t k = order_[i];
      if (k < planes_.size()) {
        for (const PlaneObservation& o : planes_[k].observations) stations.push_back(o.station);
      } else {
        const LinkScore& score = scores_[k - planes_.size()];
        stations.insert(stations.end(), {score.source, score.target});
      }
    }
    Block block(std::move(stations));
    for (std::size_t i = begins_[b]; i < begins_[b + 1]; ++i) {
      const std::size_t k = order_[i];
      if (k < planes_.size()) {
        block.Add(ComputePlaneTerms(planes_[k], poses_));
      } else {
        block.Add(scores_[k - planes_.size()]);
      }
    }
    return block;
  }

 private:
  std::span<const WeightedPlane> planes_;
  std::span<const LinkScore> scores_;
  std::span<const RigidTransform> poses_;
  std::vector<std::size_t> order_;   ///< planes, then scores, by block
  std::vector<std::size_t> begins_;  ///< of each block in `order_`, and the end of the last
};

}  // namespace

PlaneAgreement Agreement(const WeightedPlane& plane, std::span<const RigidTransform> poses) {
  std::vector<PointCluster> clusters(1);  // the joint one, then every station's own
  for (const PlaneObservation& o : plane.observations) {
    const RigidTransform& pose = poses[static_cast<std::size_t>(o.station)];
    clusters.front() += Transformed(pose.rotation, pose.translation, o.cluster);
    clusters.push_back(o.cluster);
  }
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
  const Blocks blocks(planes, scores, block, poses);
  std::vector<BlockSums> sums(blocks.size());
  context.ParallelFor(sums.size(),
                      [&](std::size_t b) { sums[b] = blocks.Make(b).Sums(covariance); });
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

ResponseScatter EstimateResponseScatter(std::span<const WeightedPlane> planes,
                                        std::span<const LinkScore> scores,
                                        std::span<const std::uint64_t> block,
                                        std::span<const RigidTransform> poses,
                                        const Eigen::MatrixXd& covariance,
                                        const ExecutionContext& context) {
  const Blocks blocks(planes, scores, block, poses);
  const std::vector<Witness> witnesses = ChooseWitnesses(poses, covariance);
  std::vector<ResponseScatter> parts(blocks.size());
  context.ParallelFor(parts.size(), [&](std::size_t b) {
    parts[b] = blocks.Make(b).Responses(witnesses, covariance);
  });
  ResponseScatter sum;
  for (const ResponseScatter& part : parts) {
    sum.turn_found += part.turn_found;
    sum.turn_expected += part.turn_expected;
    sum.shift_found += part.shift_found;
    sum.shift_expected += part.shift_expected;
  }
  return sum;
}

}  // namespace backsight
