#include "tests/benchmarks/pcl_registration.h"

#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/sample_consensus_prerejective.h>
#include <pcl/registration/transformation_estimation_point_to_plane_lls.h>

#include <algorithm>
#include <memory>

namespace backsight {
namespace {

using Points = pcl::PointCloud<pcl::PointXYZ>;
using Oriented = pcl::PointCloud<pcl::PointNormal>;
using Signatures = pcl::PointCloud<pcl::FPFHSignature33>;

Points::Ptr MakePoints(std::span<const Eigen::Vector3d> points) {
  auto cloud = std::make_shared<Points>();
  for (const Eigen::Vector3d& p : points) {
    cloud->push_back(
        {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  }
  return cloud;
}

Signatures::Ptr MakeSignatures(std::span<const FpfhDescriptor> descriptors) {
  auto cloud = std::make_shared<Signatures>();
  for (const FpfhDescriptor& d : descriptors) {
    pcl::FPFHSignature33 signature;
    std::copy(d.begin(), d.end(), signature.histogram);
    cloud->push_back(signature);
  }
  return cloud;
}

std::vector<pcl::Indices> Nearest(const Signatures::Ptr& queries, const Signatures::Ptr& others,
                                  int neighbors) {
  pcl::KdTreeFLANN<pcl::FPFHSignature33> tree;
  tree.setInputCloud(others);
  std::vector<pcl::Indices> nearest(queries->size());
  std::vector<float> squared;
  for (std::size_t i = 0; i < queries->size(); ++i) {
    tree.nearestKSearch((*queries)[i], static_cast<unsigned>(neighbors), nearest[i], squared);
  }
  return nearest;
}

RigidTransform FromMatrix(const Eigen::Matrix4f& matrix) {
  return {NearestRotation(matrix.topLeftCorner<3, 3>().cast<double>()),
          matrix.topRightCorner<3, 1>().cast<double>()};
}

Eigen::Matrix4f ToMatrix(const RigidTransform& motion) {
  Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
  matrix.topLeftCorner<3, 3>() = motion.rotation.cast<float>();
  matrix.topRightCorner<3, 1>() = motion.translation.cast<float>();
  return matrix;
}

Oriented::Ptr WithNormals(std::span<const Eigen::Vector3d> points,
                          std::span<const Eigen::Vector3f> normals) {
  auto cloud = std::make_shared<Oriented>();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!normals.empty() && !normals[i].allFinite()) continue;
    pcl::PointNormal point;
    point.x = static_cast<float>(points[i].x());
    point.y = static_cast<float>(points[i].y());
    point.z = static_cast<float>(points[i].z());
    if (!normals.empty()) {
      point.normal_x = normals[i].x();
      point.normal_y = normals[i].y();
      point.normal_z = normals[i].z();
    }
    cloud->push_back(point);
  }
  return cloud;
}

}  // namespace

std::vector<DescriptorMatch> PclMatches(std::span<const FpfhDescriptor> source,
                                        std::span<const FpfhDescriptor> target, int neighbors) {
  const Signatures::Ptr a = MakeSignatures(source);
  const Signatures::Ptr b = MakeSignatures(target);
  const std::vector<pcl::Indices> of_source = Nearest(a, b, neighbors);
  const std::vector<pcl::Indices> of_target = Nearest(b, a, neighbors);
  std::vector<DescriptorMatch> matches;
  for (std::size_t s = 0; s < source.size(); ++s) {
    for (const int t : of_source[s]) {
      const pcl::Indices& back = of_target[static_cast<std::size_t>(t)];
      if (std::find(back.begin(), back.end(), static_cast<int>(s)) == back.end()) continue;
      matches.push_back({static_cast<std::uint32_t>(s), static_cast<std::uint32_t>(t)});
    }
  }
  return matches;
}

RigidTransform PclPrerejective(std::span<const Eigen::Vector3d> source,
                               std::span<const FpfhDescriptor> source_descriptors,
                               std::span<const Eigen::Vector3d> target,
                               std::span<const FpfhDescriptor> target_descriptors,
                               double resolution_m) {
  pcl::SampleConsensusPrerejective<pcl::PointXYZ, pcl::PointXYZ, pcl::FPFHSignature33> search;
  search.setInputSource(MakePoints(source));
  search.setSourceFeatures(MakeSignatures(source_descriptors));
  search.setInputTarget(MakePoints(target));
  search.setTargetFeatures(MakeSignatures(target_descriptors));
  search.setMaximumIterations(50000);
  search.setNumberOfSamples(3);
  search.setCorrespondenceRandomness(5);
  search.setSimilarityThreshold(0.9F);
  search.setMaxCorrespondenceDistance(3.0 * resolution_m);
  search.setInlierFraction(0.05F);
  Points aligned;
  search.align(aligned);
  return FromMatrix(search.getFinalTransformation());
}

RigidTransform PclGicp(std::span<const Eigen::Vector3d> source,
                       std::span<const Eigen::Vector3d> target, const RigidTransform& start,
                       double reach_m) {
  pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
  icp.setInputSource(MakePoints(source));
  icp.setInputTarget(MakePoints(target));
  icp.setMaxCorrespondenceDistance(reach_m);
  Points aligned;
  icp.align(aligned, ToMatrix(start));
  return FromMatrix(icp.getFinalTransformation());
}

RigidTransform PclPointToPlane(std::span<const Eigen::Vector3d> source,
                               std::span<const Eigen::Vector3d> target,
                               std::span<const Eigen::Vector3f> target_normals,
                               const RigidTransform& start, double reach_m) {
  pcl::IterativeClosestPoint<pcl::PointNormal, pcl::PointNormal> icp;
  icp.setTransformationEstimation(
      std::make_shared<pcl::registration::TransformationEstimationPointToPlaneLLS<
          pcl::PointNormal, pcl::PointNormal>>());
  icp.setInputSource(WithNormals(source, {}));
  icp.setInputTarget(WithNormals(target, target_normals));
  icp.setMaxCorrespondenceDistance(reach_m);
  icp.setMaximumIterations(30);
  Oriented aligned;
  icp.align(aligned, ToMatrix(start));
  return FromMatrix(icp.getFinalTransformation());
}

}  // namespace backsight
