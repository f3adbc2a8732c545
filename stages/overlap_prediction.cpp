#include "stages/overlap_prediction.h"

#include <algorithm>

#include "core/even_choice.h"

namespace backsight {

CoarseOccupancy::CoarseOccupancy(const StationModel& model, int sample) {
  constexpr double kCellVoxels =
      3.0;  // a voxel and its neighbours, as the verification counts them
  lattice_.edge_m = kCellVoxels * model.resolution_m();
  cells_.reserve(model.leaves.size());
  for (const Eigen::Vector3d& mean : model.leaves.means()) cells_.push_back(lattice_.Key(mean));
  std::sort(cells_.begin(), cells_.end());
  cells_.erase(std::unique(cells_.begin(), cells_.end()), cells_.end());
  cells_.shrink_to_fit();
  const EvenChoice chosen(model.leaves.size(), static_cast<std::size_t>(sample));
  for (std::size_t i = 0; i < chosen.count(); ++i) {
    sample_.push_back(model.leaves.Mean(chosen[i]));
  }
}

double CoarseOccupancy::ShareOf(const CoarseOccupancy& moved,
                                const RigidTransform& this_from_moved) const {
  if (moved.sample_.empty()) return 0.0;
  const auto met =
      std::count_if(moved.sample_.begin(), moved.sample_.end(), [&](const Eigen::Vector3d& sample) {
        const Eigen::Vector3d point = this_from_moved * sample;
        return lattice_.Contains(point) &&
               std::binary_search(cells_.begin(), cells_.end(), lattice_.Key(point));
      });
  return static_cast<double>(met) / static_cast<double>(moved.sample_.size());
}

double PredictOverlap(const CoarseOccupancy& source, const CoarseOccupancy& target,
                      const RigidTransform& target_from_source) {
  return std::min(target.ShareOf(source, target_from_source),
                  source.ShareOf(target, target_from_source.Inverse()));
}

}  // namespace backsight
