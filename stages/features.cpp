#include "stages/features.h"

#include <algorithm>
#include <cmath>

#include "stages/fpfh.h"
#include "stages/iss_keypoints.h"
#include "stages/leaf_grid.h"
#include "stages/normal_orientation.h"
#include "stages/normals.h"

namespace backsight {
namespace {

/// Cells of four voxels hold some eighteen points each and cut a ball of 8 voxels finely enough.
constexpr double kCellEdge = 4.0;  // voxels

std::vector<Eigen::Vector3f> Positions(const StationModel& model) {
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(model.leaves.size());
  for (const Eigen::Vector3d& mean : model.leaves.means()) {
    positions.push_back(mean.cast<float>());
  }
  return positions;
}

IssParameters MakeIssParameters(const FeatureOptions& options, double resolution_m) {
  return {.salient_radius_m = options.salient_radius * resolution_m,
          .non_max_radius_m = options.non_max_radius * resolution_m,
          .gamma_21 = options.gamma_21,
          .gamma_32 = options.gamma_32,
          .min_neighbors = options.min_neighbors,
          .keypoints = options.keypoints};
}

/// Keeps the key points that have a normal and a finite descriptor.
void KeepDescribed(const std::vector<std::uint32_t>& keypoints,
                   const std::vector<FpfhDescriptor>& descriptors, StationFeatures* features) {
  for (std::size_t k = 0; k < keypoints.size(); ++k) {
    const bool described = features->normals[keypoints[k]].allFinite() &&
                           std::all_of(descriptors[k].begin(), descriptors[k].end(),
                                       [](float value) { return std::isfinite(value); });
    if (!described) continue;
    features->keypoints.push_back(keypoints[k]);
    features->descriptors.push_back(descriptors[k]);
  }
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, FeatureOptions& options) {
  visitor.Real("normal_radius", options.normal_radius, "voxels", 1.5, 20.0,
               "radius of the neighbourhood of a normal");
  visitor.Real("salient_radius", options.salient_radius, "voxels", 2.0, 40.0,
               "ISS: radius of the neighbourhood whose shape makes a key point");
  visitor.Real("non_max_radius", options.non_max_radius, "voxels", 1.0, 40.0,
               "ISS: a key point is the most salient within this radius; largest that is tried");
  visitor.Integer("keypoints", options.keypoints, "1", 0, 1000000,
                  "ISS: fewest key points wanted; non_max_radius is shortened to 3/4, 1/2 and at "
                  "most 3/8 to reach them");
  visitor.Real("gamma_21", options.gamma_21, "1", 0.1, 1.0,
               "ISS: largest ratio of the second to the first eigenvalue");
  visitor.Real("gamma_32", options.gamma_32, "1", 0.1, 1.0,
               "ISS: largest ratio of the third to the second eigenvalue");
  visitor.Integer("min_neighbors", options.min_neighbors, "1", 3, 1000,
                  "ISS: fewest neighbours of a key point");
  visitor.Real("descriptor_radius", options.descriptor_radius, "voxels", 2.0, 60.0,
               "FPFH: radius of the neighbourhood that a key point is described by");
}

StationFeatures ComputeFeatures(const StationModel& model, const FeatureOptions& options,
                                const ExecutionContext& context) {
  context.CheckStop();
  const double resolution_m = model.resolution_m();
  const LeafGrid grid(Positions(model), kCellEdge * resolution_m);
  StationFeatures features;
  features.normals = EstimateNormals(grid, options.normal_radius * resolution_m, context);
  features.scanner_credible = OrientNormals(model, context, &features.normals).scanner_credible;
  context.CheckStop();
  const auto keypoints = FindIssKeypoints(grid, MakeIssParameters(options, resolution_m), context);
  context.CheckStop();
  const auto descriptors = ComputeFpfh(grid, features.normals, keypoints,
                                       options.descriptor_radius * resolution_m, context);
  KeepDescribed(keypoints, descriptors, &features);
  return features;
}

}  // namespace backsight
