#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "core/random.h"
#include "stages/cloud_agreement.h"
#include "stages/features.h"

namespace backsight {

struct HallOptions {
  int boxes = 8;  ///< machines; none leaves a hall that no scan can tell from itself turned round
  Eigen::Vector3d size_m = Eigen::Vector3d(18.0, 11.0, 5.0);
};

/// A hall with boxes on its floor: symmetric under a half turn but for the boxes. The world's
/// origin is the middle of the floor.
class HallScene {
 public:
  HallScene(std::uint64_t seed, const HallOptions& options);

  /// The same hall with people in it, each as large as one.
  HallScene WithPeople(std::uint64_t seed, int people) const;

  /// The same hall with one more box on its floor.
  HallScene WithBox(const Eigen::Vector2d& center, const Eigen::Vector3d& size) const;

  /// Where a ray from inside meets the first surface.
  Eigen::Vector3d Hit(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const;

 private:
  void AddBox(const Eigen::Vector2d& center, const Eigen::Vector3d& size);

  Eigen::AlignedBox3d hall_;
  std::vector<Eigen::AlignedBox3d> boxes_;
};

struct HallScan {
  double step_deg = 0.4;      ///< between rays
  double noise_m = 0.002;     ///< of ranges
  double resolution_m = 0.1;  ///< l
};

/// A scan of the hall from a place in the world under a random heading: model, features and index.
struct HallStation {
  HallStation(const HallScene& scene, const Eigen::Vector3d& place, std::uint64_t seed,
              const HallScan& scan = {});

  Surface surface() const { return {model, features.normals, true}; }

  RigidTransform world_from_station;
  StationModel model;
  StationFeatures features;
  CloudIndex index;
};

/// The station whose scanner at the origin measured these points, with its range image (0.25 deg).
StationModel MakeSeenStation(std::span<const Eigen::Vector3d> points, double resolution_m);

}  // namespace backsight
