#include "stages/station_model.h"

namespace backsight {

RangeImage ImageOf(const VoxelLeaves& leaves, double pixel_deg) {
  RangeImage image(Eigen::Vector3d::Zero(), pixel_deg);
  for (const Eigen::Vector3d& mean : leaves.means()) image.Add(mean);
  return image;
}

}  // namespace backsight
