#include "stages/station_model.h"

namespace backsight {

RangeImage ImageOf(const std::vector<VoxelLeaf>& leaves, double pixel_deg) {
  RangeImage image(Eigen::Vector3d::Zero(), pixel_deg);
  for (const VoxelLeaf& leaf : leaves) image.Add(leaf.cluster.mean);
  return image;
}

}  // namespace backsight
