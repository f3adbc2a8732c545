#include "stages/features.h"

#include <pcl/features/fpfh.h>
#include <pcl/features/normal_3d.h>
#include <pcl/keypoints/iss_3d.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "stages/normal_orientation.h"

namespace backsight {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Normals = pcl::PointCloud<pcl::Normal>;
using Tree = pcl::search::KdTree<pcl::PointXYZ>;

Cloud::Ptr MakeCloud(const StationModel& model) {
  auto cloud = std::make_shared<Cloud>();
  cloud->reserve(model.leaves.size());
  for (const VoxelLeaf& leaf : model.leaves) {
    const Eigen::Vector3f p = leaf.cluster.mean.cast<float>();
    cloud->push_back({p.x(), p.y(), p.z()});
  }
  return cloud;
}

/// Unit normals of either sign; NaN where there are too few neighbours.
std::vector<Eigen::Vector3f> ComputeNormals(const Cloud::Ptr& cloud, const Tree::Ptr& tree,
                                            double radius_m) {
  Normals estimated;
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(tree);
  estimation.setRadiusSearch(radius_m);
  estimation.compute(estimated);
  std::vector<Eigen::Vector3f> normals;
  normals.reserve(estimated.size());
  for (const pcl::Normal& n : estimated) normals.emplace_back(n.normal_x, n.normal_y, n.normal_z);
  return normals;
}

std::vector<std::uint32_t> FindKeypoints(const Cloud::Ptr& cloud, const Tree::Ptr& tree,
                                         double resolution_m, const FeatureOptions& options) {
  pcl::ISSKeypoint3D<pcl::PointXYZ, pcl::PointXYZ> iss;
  iss.setInputCloud(cloud);
  iss.setSearchMethod(tree);
  iss.setSalientRadius(options.salient_radius * resolution_m);
  iss.setNonMaxRadius(options.non_max_radius * resolution_m);
  iss.setThreshold21(options.gamma_21);
  iss.setThreshold32(options.gamma_32);
  iss.setMinNeighbors(options.min_neighbors);
  Cloud ignored;
  iss.compute(ignored);
  std::vector<std::uint32_t> keypoints;
  for (const int index : iss.getKeypointsIndices()->indices) {
    keypoints.push_back(static_cast<std::uint32_t>(index));
  }
  std::sort(keypoints.begin(), keypoints.end());
  return keypoints;
}

/// FPFH at the key points over all leaves that have a normal. Key points whose descriptor is not
/// finite are removed from `features`.
void ComputeDescriptors(const Cloud::Ptr& cloud, double radius_m, StationFeatures* features) {
  const std::vector<Eigen::Vector3f>& normals = features->normals;
  auto surface = std::make_shared<Cloud>();
  auto surface_normals = std::make_shared<Normals>();
  for (std::size_t i = 0; i < cloud->size(); ++i) {
    const Eigen::Vector3f& n = normals[i];
    if (!n.allFinite()) continue;
    surface->push_back((*cloud)[i]);
    surface_normals->push_back({n.x(), n.y(), n.z()});
  }
  std::erase_if(features->keypoints, [&](std::uint32_t i) { return !normals[i].allFinite(); });
  auto keypoint_cloud = std::make_shared<Cloud>();
  for (const std::uint32_t i : features->keypoints) keypoint_cloud->push_back((*cloud)[i]);

  pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> estimation;
  estimation.setInputCloud(keypoint_cloud);
  estimation.setSearchSurface(surface);
  estimation.setInputNormals(surface_normals);
  estimation.setSearchMethod(std::make_shared<Tree>());
  estimation.setRadiusSearch(radius_m);
  pcl::PointCloud<pcl::FPFHSignature33> signatures;
  if (!keypoint_cloud->empty()) estimation.compute(signatures);
  BACKSIGHT_CHECK(signatures.size() == features->keypoints.size(), "one descriptor per key point");

  std::vector<std::uint32_t> kept;
  for (std::size_t k = 0; k < signatures.size(); ++k) {
    FpfhDescriptor descriptor;
    std::copy(std::begin(signatures[k].histogram), std::end(signatures[k].histogram),
              descriptor.begin());
    if (!std::all_of(descriptor.begin(), descriptor.end(), [](float v) { return std::isfinite(v); })) {
      continue;
    }
    kept.push_back(features->keypoints[k]);
    features->descriptors.push_back(descriptor);
  }
  features->keypoints = std::move(kept);
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, FeatureOptions& options) {
  visitor.Real("normal_radius", options.normal_radius, "voxels", 1.5, 20.0,
               "radius of the neighbourhood of a normal");
  visitor.Real("salient_radius", options.salient_radius, "voxels", 2.0, 40.0,
               "ISS: radius of the neighbourhood whose shape makes a key point");
  visitor.Real("non_max_radius", options.non_max_radius, "voxels", 1.0, 40.0,
               "ISS: a key point is the most salient within this radius");
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
  const Cloud::Ptr cloud = MakeCloud(model);
  auto tree = std::make_shared<Tree>();
  tree->setInputCloud(cloud);
  StationFeatures features;
  features.normals = ComputeNormals(cloud, tree, options.normal_radius * model.resolution_m());
  features.scanner_credible =
      OrientNormals(model, model.scanner_known, &features.normals).scanner_credible;
  context.CheckStop();
  features.keypoints = FindKeypoints(cloud, tree, model.resolution_m(), options);
  context.CheckStop();
  ComputeDescriptors(cloud, options.descriptor_radius * model.resolution_m(), &features);
  return features;
}

}  // namespace backsight
