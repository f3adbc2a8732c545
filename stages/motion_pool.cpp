#include "stages/motion_pool.h"

#include <algorithm>
#include <numbers>

namespace backsight {

MotionPool::MotionPool(const Eigen::Vector3d& center, double near_m,
                       std::optional<double> max_tilt_rad, MotionScore score, MotionScore bound)
    : center_(center),
      near_m_(near_m),
      max_tilt_rad_(max_tilt_rad),
      score_(std::move(score)),
      bound_(std::move(bound)) {}

void MotionPool::Add(const RigidTransform& motion) {
  constexpr double kCoarseError = 0.05;  // rad, of a motion that is not refined yet
  if (max_tilt_rad_ && RelativeTilt(motion) > *max_tilt_rad_ + kCoarseError) return;
  entries_.push_back(
      {motion, bound_ ? bound_(motion) : std::numeric_limits<double>::infinity(), std::nullopt});
}

std::vector<ScoredMotion> MotionPool::Best(std::size_t count, std::size_t rough) {
  for (;;) {
    // Whatever is not scored yet scores no more than this, and so touches nothing above it.
    const double unknown = HighestBound();
    std::vector<ScoredMotion> list = ListAbove(unknown);
    const bool rest_is_worthless = unknown <= 0.0 && list.size() >= rough;
    if (list.size() >= count || rest_is_worthless ||
        unknown == -std::numeric_limits<double>::infinity()) {
      list.resize(std::min(list.size(), count));
      return list;
    }
    ScoreMostPromising();
  }
}

/// Of the entries that are not scored.
double MotionPool::HighestBound() const {
  double highest = -std::numeric_limits<double>::infinity();
  for (const Entry& entry : entries_) {
    if (!entry.score) highest = std::max(highest, entry.bound);
  }
  return highest;
}

/// A few at a time, those with the highest bounds.
void MotionPool::ScoreMostPromising() {
  constexpr std::size_t kBatch = 4;
  std::vector<Entry*> open;
  for (Entry& entry : entries_) {
    if (!entry.score) open.push_back(&entry);
  }
  std::stable_sort(open.begin(), open.end(),
                   [](const Entry* a, const Entry* b) { return a->bound > b->bound; });
  open.resize(std::min(open.size(), kBatch));
  for (Entry* entry : open) entry->score = score_(entry->motion);
}

/// The list that the entries with scores above `least` make when they come in turn.
std::vector<ScoredMotion> MotionPool::ListAbove(double least) const {
  std::vector<ScoredMotion> list;
  for (const Entry& entry : entries_) {
    if (!entry.score || !(*entry.score > least)) continue;
    const double score = *entry.score;
    const auto like = [&](const ScoredMotion& other) { return Alike(other.motion, entry.motion); };
    const bool known = std::any_of(list.begin(), list.end(), [&](const ScoredMotion& other) {
      return other.score >= score && like(other);
    });
    if (known) continue;
    std::erase_if(list, like);
    const auto worse = [&](const ScoredMotion& other) { return other.score < score; };
    list.insert(std::find_if(list.begin(), list.end(), worse), {entry.motion, score});
  }
  return list;
}

/// Closer than 5 deg and near at the middle of the correspondences.
bool MotionPool::Alike(const RigidTransform& a, const RigidTransform& b) const {
  constexpr double kNearAngle = 5.0 * std::numbers::pi / 180.0;
  return (a * center_ - b * center_).norm() < near_m_ &&
         RotationAngle(a.rotation, b.rotation) < kNearAngle;
}

}  // namespace backsight
