#pragma once

#include <cstdint>
#include <vector>

#include "core/rigid_transform.h"
#include "stages/station_model.h"

namespace backsight {

/// A station's occupied space at three times its resolution, and a sample of its voxels: enough to
/// predict how much two stations overlap, some 50 us a pair. Instrument frame.
class CoarseOccupancy {
 public:
  /// O(voxels log voxels). `sample`: voxels looked at per direction.
  explicit CoarseOccupancy(const StationModel& model, int sample = 500);

  /// Share of `moved`'s sample that falls into occupied space of this station, 0 to 1. Somewhat
  /// larger than CompareClouds' of stages/cloud_agreement.h, because the cells are larger.
  double ShareOf(const CoarseOccupancy& moved, const RigidTransform& this_from_moved) const;

 private:
  VoxelLattice lattice_;
  std::vector<std::uint64_t> cells_;  // sorted
  std::vector<Eigen::Vector3d> sample_;
};

/// The smaller share of both directions.
double PredictOverlap(const CoarseOccupancy& source, const CoarseOccupancy& target,
                      const RigidTransform& target_from_source);

}  // namespace backsight
