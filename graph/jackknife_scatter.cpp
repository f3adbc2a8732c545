#include "graph/jackknife_scatter.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <vector>

namespace backsight {
namespace {

struct Pull {
  std::vector<int> stations;
  Eigen::VectorXd vector;  // 6 rows for each
};

/// p of JackknifeScatter. With C = K K^T and S = K^T H K, K^T p = (I - S)^-1 K^T g.
Pull LeftOutPull(const BlockEquations& sum, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd part = sum.Part(covariance);
  const Eigen::Index fixed = sum.stations.front() == 0 ? 6 : 0;
  const Eigen::Index free = part.rows() - fixed;
  Pull pull{sum.stations, Eigen::VectorXd::Zero(part.rows())};
  if (free == 0) return pull;
  const Eigen::LLT<Eigen::MatrixXd> root(part.bottomRightCorner(free, free));
  const Eigen::MatrixXd lower = root.matrixL();
  const Eigen::MatrixXd shares =
      lower.transpose() * sum.matrix.bottomRightCorner(free, free) * lower;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(shares);
  constexpr double kLeastRest = 0.25;
  const Eigen::VectorXd rest = (1.0 - solver.eigenvalues().array()).max(kLeastRest);
  const Eigen::VectorXd along =
      solver.eigenvectors().transpose() * (lower.transpose() * sum.gradient.tail(free));
  const Eigen::VectorXd left = solver.eigenvectors() * along.cwiseQuotient(rest);
  pull.vector.tail(free) = root.matrixU().solve(left);
  return pull;
}

void AddSquare(const Pull& pull, Eigen::MatrixXd* scatter) {
  const auto part = [&](std::size_t s) {
    return pull.vector.segment<6>(static_cast<Eigen::Index>(6 * s));
  };
  for (std::size_t a = 0; a < pull.stations.size(); ++a) {
    for (std::size_t b = 0; b < pull.stations.size(); ++b) {
      scatter->block<6, 6>(6 * pull.stations[a], 6 * pull.stations[b]).noalias() +=
          part(a) * part(b).transpose();
    }
  }
}

}  // namespace

Eigen::MatrixXd JackknifeScatter(const BlockMembers& members, std::span<const RigidTransform> poses,
                                 double slope, const Eigen::MatrixXd& covariance,
                                 const ExecutionContext& context) {
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(covariance.rows(), covariance.cols());
  const BlockList blocks(members.block);
  constexpr std::size_t kBatch = 4096;  // blocks whose pulls are in memory at a time
  std::vector<Pull> pulls;
  for (std::size_t begin = 0; begin < blocks.size(); begin += kBatch) {
    pulls.resize(std::min(kBatch, blocks.size() - begin));
    context.ParallelFor(pulls.size(), [&](std::size_t b) {
      const BlockEquations sum =
          SumBlock(members, blocks[begin + b], poses, PlaneCurvature::kExact, slope);
      pulls[b] = LeftOutPull(sum, covariance);
    });
    for (const Pull& pull : pulls) AddSquare(pull, &scatter);
  }
  return scatter;
}

}  // namespace backsight
