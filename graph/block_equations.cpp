#include "graph/block_equations.h"

#include <algorithm>
#include <numeric>

#include "graph/pose_observations.h"

namespace backsight {
namespace {

std::vector<int> StationsOf(const BlockMembers& members, std::span<const std::size_t> block) {
  std::vector<int> stations;
  for (const std::size_t k : block) {
    if (k < members.planes.size()) {
      for (const PlaneObservation& o : members.planes[k].observations) {
        stations.push_back(o.station);
      }
    } else {
      const LinkScore& score = members.scores[k - members.planes.size()];
      stations.insert(stations.end(), {score.source, score.target});
    }
  }
  std::sort(stations.begin(), stations.end());
  stations.erase(std::unique(stations.begin(), stations.end()), stations.end());
  return stations;
}

Eigen::Index RowOf(const BlockEquations& sum, int station) {
  return 6 * (std::lower_bound(sum.stations.begin(), sum.stations.end(), station) -
              sum.stations.begin());
}

void AddPlane(const PlaneTerms& plane, double slope, BlockEquations* sum) {
  for (const PlaneTerms::Part& a : plane.parts) {
    const Eigen::Index i = RowOf(*sum, a.station);
    sum->gradient.segment<6>(i) += a.gradient;
    sum->matrix.block<6, 6>(i, i) += slope * a.held;
    for (const PlaneTerms::Part& b : plane.parts) {
      sum->matrix.block<6, 6>(i, RowOf(*sum, b.station)).noalias() -=
          slope * a.coupling * b.coupling.transpose();
    }
  }
}

void AddScore(const LinkScore& score, const Matrix6d& matrix, BlockEquations* sum) {
  const Eigen::Index i = RowOf(*sum, score.source);
  const Eigen::Index j = RowOf(*sum, score.target);
  sum->gradient.segment<6>(i) += score.gradient;
  sum->gradient.segment<6>(j) -= score.gradient;
  AddRelative(i, j, matrix, &sum->matrix);
}

}  // namespace

BlockList::BlockList(std::span<const std::uint64_t> block) : order_(block.size()) {
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::size_t a, std::size_t b) { return block[a] < block[b]; });
  for (std::size_t i = 0; i < order_.size(); ++i) {
    if (i == 0 || block[order_[i]] != block[order_[i - 1]]) begins_.push_back(i);
  }
  begins_.push_back(order_.size());
}

Eigen::MatrixXd BlockEquations::Part(const Eigen::MatrixXd& of_all) const {
  Eigen::MatrixXd part(matrix.rows(), matrix.cols());
  for (std::size_t a = 0; a < stations.size(); ++a) {
    for (std::size_t b = 0; b < stations.size(); ++b) {
      part.block<6, 6>(static_cast<Eigen::Index>(6 * a), static_cast<Eigen::Index>(6 * b)) =
          of_all.block<6, 6>(6 * stations[a], 6 * stations[b]);
    }
  }
  return part;
}

BlockEquations SumBlock(const BlockMembers& members, std::span<const std::size_t> block,
                        std::span<const RigidTransform> poses, PlaneCurvature curvature,
                        double slope) {
  BlockEquations sum;
  sum.stations = StationsOf(members, block);
  const auto rows = static_cast<Eigen::Index>(6 * sum.stations.size());
  sum.gradient = Eigen::VectorXd::Zero(rows);
  sum.matrix = Eigen::MatrixXd::Zero(rows, rows);
  for (const std::size_t k : block) {
    if (k < members.planes.size()) {
      AddPlane(ComputePlaneTerms(members.planes[k], poses, curvature), slope, &sum);
    } else {
      const LinkScore& score = members.scores[k - members.planes.size()];
      AddScore(score, curvature == PlaneCurvature::kExact ? score.known : score.matrix, &sum);
    }
  }
  return sum;
}

}  // namespace backsight
