#pragma once

#include "core/execution.h"
#include "core/option_visitor.h"
#include "stages/station_model.h"

namespace backsight {

/// Radii are in voxels (multiples of the station's resolution l).
struct FeatureOptions {
  double normal_radius = 3.0;
  double salient_radius = 6.0;     ///< ISS: neighbourhood of the scatter matrix
  double non_max_radius = 4.0;     ///< ISS: non-maximum suppression, largest radius tried
  int keypoints = 1500;            ///< ISS: fewest key points wanted (FindIssKeypoints)
  double gamma_21 = 0.975;         ///< ISS: largest ratio of second to first eigenvalue
  double gamma_32 = 0.975;         ///< ISS: largest ratio of third to second eigenvalue
  int min_neighbors = 4;           ///< ISS
  double descriptor_radius = 8.0;  ///< FPFH
};
void VisitOptions(OptionVisitor& visitor, FeatureOptions& options);

/// Normals (PCA, towards the scanner), ISS key points (Zhong 2009, doi 10.1109/ICCVW.2009.5457637)
/// and their FPFH descriptors (Rusu 2009, doi 10.1109/ROBOT.2009.5152473) on the voxel means.
StationFeatures ComputeFeatures(const StationModel& model, const FeatureOptions& options,
                                const ExecutionContext& context);

}  // namespace backsight
