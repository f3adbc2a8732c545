#include "stages/plan_motions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "core/even_choice.h"

namespace backsight {
namespace {

double ViewScore(std::span<const Eigen::Vector3d> surface, const StationModel& viewer,
                 const RigidTransform& viewer_from_surface) {
  int score = 0;
  for (const Eigen::Vector3d& sample : surface) {
    const Eigen::Vector3d point = viewer_from_surface * sample;
    const auto farthest = static_cast<double>(viewer.range_image.At(point).max_m);
    if (farthest == 0.0) continue;
    const double range = point.norm();
    // As in the verification: three voxels and what 1 degree of incidence or pointing makes of it.
    const double tolerance = std::min(3.0 * viewer.resolution_m() + 0.02 * range, 1.0);
    if (range < farthest - tolerance) {
      --score;
    } else if (range <= farthest + tolerance) {
      ++score;
    }
  }
  return surface.empty() ? 0.0 : static_cast<double>(score) / static_cast<double>(surface.size());
}

/// Climbs to the best of a motion's neighbours, first along heading, then along x and y.
class Climber {
 public:
  Climber(const MotionScore& score, const RigidTransform& start)
      : score_(score), best_{start, score(start)} {}

  void StepHeading(double step_rad) {
    const RigidTransform start = best_.motion;
    for (const double turn : {-step_rad, step_rad}) {
      RigidTransform moved = start;
      moved.rotation =
          Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix() * start.rotation;
      Try(moved);
    }
  }

  void StepPlace(double step_m) {
    const RigidTransform start = best_.motion;
    for (const Eigen::Vector2d& step :
         {Eigen::Vector2d(step_m, 0.0), Eigen::Vector2d(0.0, step_m), Eigen::Vector2d(-step_m, 0.0),
          Eigen::Vector2d(0.0, -step_m)}) {
      RigidTransform moved = start;
      moved.translation.head<2>() += step;
      Try(moved);
    }
  }

  const ScoredMotion& best() const { return best_; }

 private:
  void Try(const RigidTransform& motion) {
    const double score = score_(motion);
    if (score > best_.score) best_ = {motion, score};
  }

  const MotionScore& score_;
  ScoredMotion best_;
};

}  // namespace

std::vector<Eigen::Vector3d> SampleSurface(const StationModel& model, std::size_t count) {
  const EvenChoice chosen(model.leaves.size(), count);
  std::vector<Eigen::Vector3d> surface;
  surface.reserve(chosen.count());
  for (std::size_t i = 0; i < chosen.count(); ++i) {
    surface.push_back(model.leaves.Mean(chosen[i]));
  }
  return surface;
}

double MutualViewScore(std::span<const Eigen::Vector3d> source_surface, const StationModel& source,
                       std::span<const Eigen::Vector3d> target_surface, const StationModel& target,
                       const RigidTransform& target_from_source) {
  return ViewScore(source_surface, target, target_from_source) +
         ViewScore(target_surface, source, target_from_source.Inverse());
}

std::vector<ScoredMotion> FindPlanMotions(const PlannedStation& source,
                                          const PlannedStation& target,
                                          const PlanCorrelationOptions& options) {
  const MotionScore score = [&](const RigidTransform& motion) {
    return MutualViewScore(source.surface, source.model, target.surface, target.model, motion);
  };
  const double half_turn_step = std::numbers::pi / options.turns;
  const double half_cell = 0.5 * source.view.cell_m();
  std::vector<ScoredMotion> motions;
  for (const PlanMatch& match : CorrelatePlans(source.view, target.view, options)) {
    Climber climber(score, match.target_from_source);
    for (const double scale : {1.0, 1.0, 0.5, 0.5}) {
      climber.StepHeading(scale * half_turn_step);
      climber.StepPlace(scale * half_cell);
    }
    motions.push_back(climber.best());
  }
  std::stable_sort(motions.begin(), motions.end(),
                   [](const ScoredMotion& a, const ScoredMotion& b) { return a.score > b.score; });
  return motions;
}

}  // namespace backsight
