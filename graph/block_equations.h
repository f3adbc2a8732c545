#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "graph/planar_cost.h"

namespace backsight {

/// Pull of some other observation of a relative pose, as it adds to the normal equations:
/// `gradient` to the source's rows, its negative to the target's, and the matrices likewise.
struct LinkScore {
  int source = 0;
  int target = 0;
  Vector6d gradient = Vector6d::Zero();              ///< left perturbations of survey_from_station
  Matrix6d matrix = Matrix6d::Zero();                ///< Gauss-Newton
  Matrix6d known = Matrix6d::Zero();                 ///< the part of it across surfaces, not along
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< where it was observed, survey frame
};

/// What may be gathered in blocks: planes, and then scores.
struct BlockMembers {
  std::span<const WeightedPlane> planes;
  std::span<const LinkScore> scores;
  std::span<const std::uint64_t> block;  ///< of each plane and then of each score, any numbers
};

/// Members by block: indices below the number of planes are planes, the others scores.
class BlockList {
 public:
  explicit BlockList(std::span<const std::uint64_t> block);
  std::size_t size() const { return begins_.size() - 1; }
  std::span<const std::size_t> operator[](std::size_t b) const {
    return std::span(order_).subspan(begins_[b], begins_[b + 1] - begins_[b]);
  }

 private:
  std::vector<std::size_t> order_;
  std::vector<std::size_t> begins_;  // and the end
};

/// Normal equations of one block, of the stations that take part in it alone.
struct BlockEquations {
  std::vector<int> stations;  ///< ascending
  Eigen::VectorXd gradient;   ///< 6 rows for each of them
  Eigen::MatrixXd matrix;

  /// Their rows and columns of a matrix of all stations.
  Eigen::MatrixXd Part(const Eigen::MatrixXd& of_all) const;
};

/// The matrix holds planes' terms of this curvature times `slope`, and of the scores the matrix
/// (Gauss-Newton) or what they know (exact).
BlockEquations SumBlock(const BlockMembers& members, std::span<const std::size_t> block,
                        std::span<const RigidTransform> poses, PlaneCurvature curvature,
                        double slope);

}  // namespace backsight
