#include "tests/support/pcl_features.h"

#include <pcl/features/fpfh.h>
#include <pcl/features/normal_3d.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/keypoints/iss_3d.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <algorithm>

namespace backsight {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Tree = pcl::search::KdTree<pcl::PointXYZ>;

Cloud::Ptr MakeCloud(std::span<const Eigen::Vector3f> points) {
  auto cloud = std::make_shared<Cloud>();
  for (const Eigen::Vector3f& p : points) cloud->push_back({p.x(), p.y(), p.z()});
  return cloud;
}

}  // namespace

std::function<std::vector<Eigen::Vector3f>()> PclVoxelGrid(std::span<const Eigen::Vector3d> points,
                                                           double edge_m) {
  auto cloud = std::make_shared<Cloud>();
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3f p = point.cast<float>();
    cloud->push_back({p.x(), p.y(), p.z()});
  }
  return [cloud, edge = static_cast<float>(edge_m)] {
    pcl::VoxelGrid<pcl::PointXYZ> grid;
    grid.setInputCloud(cloud);
    grid.setLeafSize(edge, edge, edge);
    Cloud thinned;
    grid.filter(thinned);
    std::vector<Eigen::Vector3f> means;
    for (const pcl::PointXYZ& p : thinned) means.emplace_back(p.x, p.y, p.z);
    return means;
  };
}

std::vector<Eigen::Vector3f> PclNormals(std::span<const Eigen::Vector3f> points, double radius_m) {
  pcl::PointCloud<pcl::Normal> estimated;
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(MakeCloud(points));
  estimation.setSearchMethod(std::make_shared<Tree>());
  estimation.setRadiusSearch(radius_m);
  estimation.compute(estimated);
  std::vector<Eigen::Vector3f> normals;
  for (const pcl::Normal& n : estimated) normals.emplace_back(n.normal_x, n.normal_y, n.normal_z);
  return normals;
}

std::vector<std::uint32_t> PclIssKeypoints(std::span<const Eigen::Vector3f> points,
                                           const IssParameters& parameters) {
  pcl::ISSKeypoint3D<pcl::PointXYZ, pcl::PointXYZ> iss;
  iss.setInputCloud(MakeCloud(points));
  iss.setSearchMethod(std::make_shared<Tree>());
  iss.setSalientRadius(parameters.salient_radius_m);
  iss.setNonMaxRadius(parameters.non_max_radius_m);
  iss.setThreshold21(parameters.gamma_21);
  iss.setThreshold32(parameters.gamma_32);
  iss.setMinNeighbors(parameters.min_neighbors);
  Cloud ignored;
  iss.compute(ignored);
  std::vector<std::uint32_t> keypoints;
  for (const int index : iss.getKeypointsIndices()->indices) {
    keypoints.push_back(static_cast<std::uint32_t>(index));
  }
  std::sort(keypoints.begin(), keypoints.end());
  return keypoints;
}

std::vector<FpfhDescriptor> PclFpfh(std::span<const Eigen::Vector3f> points,
                                    std::span<const Eigen::Vector3f> normals,
                                    std::span<const std::uint32_t> keypoints, double radius_m) {
  auto surface = std::make_shared<Cloud>();
  auto surface_normals = std::make_shared<pcl::PointCloud<pcl::Normal>>();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!normals[i].allFinite()) continue;
    surface->push_back({points[i].x(), points[i].y(), points[i].z()});
    surface_normals->push_back({normals[i].x(), normals[i].y(), normals[i].z()});
  }
  auto queries = std::make_shared<Cloud>();
  for (const std::uint32_t i : keypoints) {
    queries->push_back({points[i].x(), points[i].y(), points[i].z()});
  }
  pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> estimation;
  estimation.setInputCloud(queries);
  estimation.setSearchSurface(surface);
  estimation.setInputNormals(surface_normals);
  estimation.setSearchMethod(std::make_shared<Tree>());
  estimation.setRadiusSearch(radius_m);
  pcl::PointCloud<pcl::FPFHSignature33> signatures;
  if (!queries->empty()) estimation.compute(signatures);
  std::vector<FpfhDescriptor> descriptors;
  for (const pcl::FPFHSignature33& signature : signatures) {
    std::copy(std::begin(signature.histogram), std::end(signature.histogram),
              descriptors.emplace_back().begin());
  }
  return descriptors;
}

}  // namespace backsight
