#include "graph/jackknife_scatter.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "graph/planar_adjustment.h"
#include "tests/support/synthetic_planes.h"

namespace backsight {
namespace {

using Poses = std::vector<RigidTransform>;

NormalEquations ExactEquations(const std::vector<WeightedPlane>& planes, const Poses& poses) {
  PlanarProblem problem{planes, {}, nullptr};
  problem.curvature = PlaneCurvature::kExact;
  return AssembleNormalEquations(problem, poses);
}

/// Inverse with the first station fixed.
Eigen::MatrixXd Inverse(const Eigen::MatrixXd& information) {
  const Eigen::Index n = information.rows() - 6;
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(n + 6, n + 6);
  inverse.bottomRightCorner(n, n) = information.bottomRightCorner(n, n).inverse();
  return inverse;
}

/// A scene at the minimum of its cost, its planes in blocks of three.
struct Adjusted {
  explicit Adjusted(std::uint64_t seed, double noise_m = 0.004) {
    scene = MakePlanes(seed, {.stations = 4, .planes = 90, .noise_m = noise_m});
    poses = AdjustPlanes(scene.planes, {}, scene.world_from_station, 0, {.relative_decrease = 0.0})
                .poses;
    for (std::size_t k = 0; k < scene.planes.size(); ++k) block.push_back(k / 3);
  }
  Eigen::MatrixXd Covariance() const { return Inverse(ExactEquations(scene.planes, poses).matrix); }
  Eigen::MatrixXd Scatter(int threads = 1) const {
    return JackknifeScatter({scene.planes, {}, block}, poses, /*slope=*/1.0, Covariance(),
                            ExecutionContext(threads));
  }

  SyntheticPlanes scene;
  Poses poses;
  std::vector<std::uint64_t> block;
};

TEST(JackknifeScatter, GivesTheStepsOfAdjustmentsWithoutABlock) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const Adjusted all(seed);
    const Eigen::Index n = 6 * 4;
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(n, n);
    for (std::uint64_t b = 0; b < 30; ++b) {
      std::vector<WeightedPlane> others;
      for (std::size_t k = 0; k < all.block.size(); ++k) {
        if (all.block[k] != b) others.push_back(all.scene.planes[k]);
      }
      const NormalEquations left = ExactEquations(others, all.poses);
      const Eigen::VectorXd step = -Inverse(left.matrix) * left.gradient;
      expected += step * step.transpose();
    }
    const Eigen::MatrixXd covariance = all.Covariance();
    const Eigen::MatrixXd actual = covariance * all.Scatter() * covariance;
    EXPECT_LT((actual - expected).norm(), 1e-4 * expected.norm()) << "seed " << seed;
  }
}

TEST(JackknifeScatter, IsTheScatterOfRepeatedMeasurements) {
  double sum = 0.0;
  constexpr int kSeeds = 40;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Adjusted all(seed + 100);
    for (std::size_t k = 0; k < all.block.size(); ++k) all.block[k] = k;
    const Eigen::MatrixXd covariance = all.Covariance();
    const Eigen::MatrixXd robust = covariance * all.Scatter() * covariance;
    for (int s = 1; s < 4; ++s) {
      const Vector6d error =
          LocalDifference(all.poses[static_cast<std::size_t>(s)],
                          all.scene.world_from_station[static_cast<std::size_t>(s)]);
      for (int i = 0; i < 6; ++i) sum += error[i] * error[i] / robust(6 * s + i, 6 * s + i) / 18.0;
    }
  }
  // The jackknife errs upwards, and the square of an error over a variance that scatters, too.
  EXPECT_GT(sum / kSeeds, 0.7);
  EXPECT_LT(sum / kSeeds, 1.3);
}

TEST(JackknifeScatter, SurfacesPullLikePlanes) {
  const Adjusted all(7);
  // What two stations alone see of a plane is, as a pull on their relative pose, a score.
  std::vector<WeightedPlane> planes;
  std::vector<LinkScore> scores;
  std::vector<std::uint64_t> as_planes, as_scores;
  for (std::size_t k = 0; k < all.block.size(); ++k) {
    planes.push_back(all.scene.planes[k]);
    as_planes.push_back(k);
  }
  as_scores = as_planes;
  std::vector<WeightedPlane> with_pairs = planes;
  for (std::size_t k = 0; k < all.block.size(); ++k) {
    const auto& o = all.scene.planes[k].observations;
    if (o.size() < 3) continue;
    const WeightedPlane pair{{o[1], o[2]}, all.scene.planes[k].weight};
    const PlaneTerms terms = ComputePlaneTerms(pair, all.poses, PlaneCurvature::kExact);
    LinkScore score;
    score.source = o[1].station;
    score.target = o[2].station;
    score.gradient = terms.parts[0].gradient;
    score.known = terms.parts[0].coupling * terms.parts[1].coupling.transpose();
    score.known = 0.5 * (score.known + score.known.transpose()).eval();
    scores.push_back(score);
    with_pairs.push_back(pair);
    as_planes.push_back(1000 + k);
    as_scores.push_back(1000 + k);
  }
  ASSERT_GT(scores.size(), 10U);
  const Eigen::MatrixXd covariance = all.Covariance() / 2.0;
  const ExecutionContext context(1);
  const Eigen::MatrixXd one =
      JackknifeScatter({with_pairs, {}, as_planes}, all.poses, 1.0, covariance, context);
  const Eigen::MatrixXd other =
      JackknifeScatter({planes, scores, as_scores}, all.poses, 1.0, covariance, context);
  EXPECT_LT((one - other).norm(), 0.02 * one.norm());
}

TEST(JackknifeScatter, ThreadsDoNotChangeABit) {
  const Adjusted all(3);
  EXPECT_EQ(all.Scatter(1), all.Scatter(4));
}

}  // namespace
}  // namespace backsight
