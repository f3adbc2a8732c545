#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "core/rigid_transform.h"

namespace backsight {

struct ScoredMotion {
  RigidTransform motion;
  double score = 0.0;
};

using MotionScore = std::function<double(const RigidTransform&)>;

/// Motions that compete. One like another (closer than 5 deg, and than `near_m` at `center`) that
/// came before it replaces it only if it scores better. Scores only what its bound does not rule
/// out; the result is the same as if all were scored.
class MotionPool {
 public:
  /// `bound` is no less than `score` for any motion; without it all are scored. Motions that tilt
  /// by more than `max_tilt_rad` and what a coarse motion is wrong by are not taken.
  MotionPool(const Eigen::Vector3d& center, double near_m, std::optional<double> max_tilt_rad,
             MotionScore score, MotionScore bound = {});

  void Add(const RigidTransform& motion);
  bool empty() const { return entries_.empty(); }

  /// The best first, `count` of them if there are as many. Those after the first `rough` may be
  /// missing where they score no more than 0.
  std::vector<ScoredMotion> Best(std::size_t count = kAll, std::size_t rough = kAll);

 private:
  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  struct Entry {
    RigidTransform motion;
    double bound = 0.0;
    std::optional<double> score;
  };

  void ScoreMostPromising();
  double HighestBound() const;
  std::vector<ScoredMotion> ListAbove(double least) const;
  bool Alike(const RigidTransform& a, const RigidTransform& b) const;

  Eigen::Vector3d center_;
  double near_m_;
  std::optional<double> max_tilt_rad_;
  MotionScore score_;
  MotionScore bound_;
  std::vector<Entry> entries_;  // in the order of their coming
};

}  // namespace backsight
