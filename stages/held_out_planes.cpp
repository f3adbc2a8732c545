#include "stages/held_out_planes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace backsight {
namespace {

/// Signed distance of b's patch from a's, positive towards station a.
double PatchDistance(const PlaneObservation& a, const PlaneObservation& b,
                     std::span<const RigidTransform> poses) {
  const RigidTransform& pose_a = poses[static_cast<std::size_t>(a.station)];
  const RigidTransform& pose_b = poses[static_cast<std::size_t>(b.station)];
  const Eigen::Matrix3d shape =
      pose_a.rotation * a.cluster.Covariance() * pose_a.rotation.transpose() +
      pose_b.rotation * b.cluster.Covariance() * pose_b.rotation.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(shape);
  Eigen::Vector3d normal = solver.eigenvectors().col(0);
  const Eigen::Vector3d on_a = pose_a * a.cluster.mean;
  if (normal.dot(pose_a.translation - on_a) < 0.0) normal = -normal;
  return normal.dot(pose_b * b.cluster.mean - on_a);
}

class ChangeSum {
 public:
  void Add(double before_m, double after_m) {
    const double change = after_m * after_m - before_m * before_m;
    count_ += 1.0;
    before_ += before_m * before_m;
    change_ += change;
    squared_ += change * change;
  }
  SquaredChange Mean() const {
    if (count_ == 0.0) return {};
    return {before_ / count_, change_ / count_, std::sqrt(squared_) / count_};
  }

 private:
  double count_ = 0.0;
  double before_ = 0.0;
  double change_ = 0.0;
  double squared_ = 0.0;
};

}  // namespace

bool SquaredChange::IsWorse(double significance) const {
  constexpr double kNoticeable = 0.01;
  constexpr double kNoChange = 1e-10;  // m^2
  return mean_change_m2 >
         std::max({significance * standard_error_m2, kNoticeable * mean_before_m2, kNoChange});
}

bool IsHeldOut(std::uint64_t cell, double share) {
  return static_cast<double>(cell >> 11U) * 0x1.0p-53 < share;
}

HeldOutComparison CompareHeldOut(std::span<const PlaneAssociation> planes,
                                 std::span<const RigidTransform> before,
                                 std::span<const RigidTransform> after) {
  std::map<std::pair<int, int>, HeldOutPair> pairs;
  std::map<std::pair<int, int>, ChangeSum> changes;
  ChangeSum all;
  for (const PlaneAssociation& plane : planes) {
    for (std::size_t i = 0; i < plane.observations.size(); ++i) {
      for (std::size_t j = i + 1; j < plane.observations.size(); ++j) {
        const PlaneObservation& a = plane.observations[i];
        const PlaneObservation& b = plane.observations[j];
        const double d0 = PatchDistance(a, b, before);
        const double d1 = PatchDistance(a, b, after);
        HeldOutPair& pair = pairs[{a.station, b.station}];
        ++pair.planes;
        pair.rms_before += d0 * d0;
        pair.rms_after += d1 * d1;
        pair.bias_before += d0;
        pair.bias_after += d1;
        changes[{a.station, b.station}].Add(d0, d1);
        all.Add(d0, d1);
      }
    }
  }
  HeldOutComparison comparison;
  for (auto& [stations, pair] : pairs) {
    std::tie(pair.a, pair.b) = stations;
    const double n = pair.planes;
    pair.rms_before = std::sqrt(pair.rms_before / n);
    pair.rms_after = std::sqrt(pair.rms_after / n);
    pair.bias_before /= n;
    pair.bias_after /= n;
    pair.change = changes[stations].Mean();
    comparison.pairs.push_back(pair);
  }
  comparison.change = all.Mean();
  return comparison;
}

}  // namespace backsight
