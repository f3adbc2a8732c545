#include "stages/held_out_planes.h"

#include <Eigen/Eigenvalues>
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

}  // namespace

bool IsHeldOut(std::uint64_t cell, double share) {
  return static_cast<double>(cell >> 11U) * 0x1.0p-53 < share;
}

HeldOutComparison CompareHeldOut(std::span<const PlaneAssociation> planes,
                                 std::span<const RigidTransform> before,
                                 std::span<const RigidTransform> after) {
  std::map<std::pair<int, int>, HeldOutPair> pairs;
  double count = 0.0;
  double before_sum = 0.0;
  double sum = 0.0;
  double squared = 0.0;
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
        const double change = d1 * d1 - d0 * d0;
        count += 1.0;
        before_sum += d0 * d0;
        sum += change;
        squared += change * change;
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
    comparison.pairs.push_back(pair);
  }
  if (count > 0.0) {
    comparison.mean_before_m2 = before_sum / count;
    comparison.mean_change_m2 = sum / count;
    comparison.standard_error_m2 = std::sqrt(squared) / count;
  }
  return comparison;
}

}  // namespace backsight
