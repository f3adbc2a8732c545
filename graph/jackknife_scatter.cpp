#include "graph/jackknife_scatter.h"

#include <Eigen/LU>
#include <algorithm>
#include <vector>

namespace backsight {
namespace {

struct Pull {
  std::vector<int> stations;
  Eigen::VectorXd vector;  // 6 rows for each
};

Pull LeftOutPull(const BlockEquations& sum, const Eigen::MatrixXd& covariance) {
  const Eigen::Index n = sum.matrix.rows();
  const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(n, n) - sum.matrix * sum.Part(covariance);
  return {sum.stations, rest.partialPivLu().solve(sum.gradient)};
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
