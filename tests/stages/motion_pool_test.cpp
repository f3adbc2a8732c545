#include "stages/motion_pool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/random.h"

namespace backsight {
namespace {

/// All motions scored and put in their places one by one.
std::vector<ScoredMotion> Reference(const std::vector<ScoredMotion>& motions, double near_m) {
  std::vector<ScoredMotion> list;
  for (const ScoredMotion& entry : motions) {
    const auto like = [&](const ScoredMotion& other) {
      return (other.motion.translation - entry.motion.translation).norm() < near_m &&
             RotationAngle(other.motion.rotation, entry.motion.rotation) < 5.0 * M_PI / 180.0;
    };
    if (std::any_of(list.begin(), list.end(), [&](const ScoredMotion& other) {
          return like(other) && other.score >= entry.score;
        })) {
      continue;
    }
    std::erase_if(list, like);
    const auto worse = [&](const ScoredMotion& other) { return other.score < entry.score; };
    list.insert(std::find_if(list.begin(), list.end(), worse), entry);
  }
  return list;
}

/// Shifts along a line, so that many are alike, with scores of few values, so that some are equal.
std::vector<ScoredMotion> RandomMotions(std::uint64_t seed) {
  Random random(seed);
  std::vector<ScoredMotion> motions(10 + random.Index(60));
  for (ScoredMotion& entry : motions) {
    entry.motion.translation = {random.Uniform(0.0, 15.0), 0.0, 0.0};
    entry.score = 0.1 * std::round(10.0 * random.Uniform(-0.5, 0.5));
  }
  return motions;
}

struct Scorer {
  explicit Scorer(const std::vector<ScoredMotion>& motions) {
    for (const ScoredMotion& m : motions) scores[m.motion.translation.x()] = m.score;
  }
  double operator()(const RigidTransform& motion) {
    ++calls;
    return scores.at(motion.translation.x());
  }
  std::map<double, double> scores;
  int calls = 0;
};

TEST(MotionPool, IsTheListOfAllScores) {
  int scored = 0;
  int all = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const std::vector<ScoredMotion> motions = RandomMotions(seed);
    const std::vector<ScoredMotion> expected = Reference(motions, 1.0);
    Scorer scorer(motions);
    Random random(1000 + seed);
    const auto bound = [&](const RigidTransform& motion) {
      return scorer.scores.at(motion.translation.x()) + 0.1 * static_cast<double>(random.Index(4));
    };
    MotionPool pool(Eigen::Vector3d::Zero(), 1.0, std::nullopt, std::ref(scorer), bound);
    for (const ScoredMotion& m : motions) pool.Add(m.motion);
    for (const std::size_t count : {1U, 4U, 8U}) {
      const std::vector<ScoredMotion> best = pool.Best(count);
      ASSERT_EQ(best.size(), std::min<std::size_t>(count, expected.size()));
      for (std::size_t i = 0; i < best.size(); ++i) {
        EXPECT_EQ(best[i].score, expected[i].score);
        EXPECT_EQ(best[i].motion.translation, expected[i].motion.translation);
      }
    }
    scored += scorer.calls;
    all += static_cast<int>(motions.size());
    EXPECT_EQ(pool.Best().size(), expected.size());
  }
  EXPECT_LT(scored, 9 * all / 10) << "bounds rule some out";
}

TEST(MotionPool, WorthlessMotionsMayBeMissingAfterTheRough) {
  for (std::uint64_t seed = 500; seed < 700; ++seed) {
    const std::vector<ScoredMotion> motions = RandomMotions(seed);
    const std::vector<ScoredMotion> expected = Reference(motions, 1.0);
    Scorer scorer(motions);
    const auto bound = [&](const RigidTransform& motion) {
      return scorer.scores.at(motion.translation.x());
    };
    MotionPool pool(Eigen::Vector3d::Zero(), 1.0, std::nullopt, std::ref(scorer), bound);
    for (const ScoredMotion& m : motions) pool.Add(m.motion);
    const std::vector<ScoredMotion> best = pool.Best(20, 2);
    for (std::size_t i = 0; i < std::min<std::size_t>(20, expected.size()); ++i) {
      if (i >= best.size()) {
        EXPECT_GE(i, 2U);
        EXPECT_LE(expected[i].score, 0.0);
        continue;
      }
      EXPECT_EQ(best[i].motion.translation, expected[i].motion.translation);
    }
  }
}

TEST(MotionPool, LeavesOutWhatTilts) {
  MotionPool pool(Eigen::Vector3d::Zero(), 1.0, 0.01, [](const RigidTransform&) { return 1.0; },
                  {});
  pool.Add({ExpSo3({0.1, 0.0, 0.0}), Eigen::Vector3d::Zero()});
  EXPECT_TRUE(pool.empty());
  EXPECT_TRUE(pool.Best().empty());
  pool.Add({ExpSo3({0.05, 0.0, 0.4}), Eigen::Vector3d::Zero()});
  EXPECT_FALSE(pool.empty());
  EXPECT_EQ(pool.Best(3).size(), 1U);
}

}  // namespace
}  // namespace backsight
