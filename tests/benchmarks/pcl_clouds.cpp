#include "tests/benchmarks/pcl_clouds.h"

#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include "core/error.h"

namespace backsight {
namespace {

using PclCloud = pcl::PointCloud<pcl::PointXYZI>;

PclCloud PclCloudOf(const std::vector<PointChunk>& chunks) {
  PclCloud cloud;
  for (const PointChunk& chunk : chunks) {
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      pcl::PointXYZI point;
      point.x = static_cast<float>(chunk.x[i]);
      point.y = static_cast<float>(chunk.y[i]);
      point.z = static_cast<float>(chunk.z[i]);
      point.intensity = chunk.intensity[i];
      cloud.push_back(point);
    }
  }
  return cloud;
}

}  // namespace

void WritePclPcd(const std::string& path, const std::vector<PointChunk>& chunks) {
  BACKSIGHT_CHECK(pcl::PCDWriter().writeBinary(path, PclCloudOf(chunks)) == 0, "PCL failed");
}

void WritePclPly(const std::string& path, const std::vector<PointChunk>& chunks) {
  constexpr bool kBinary = true;
  constexpr bool kCamera = false;
  BACKSIGHT_CHECK(pcl::PLYWriter().write(path, PclCloudOf(chunks), kBinary, kCamera) == 0,
                  "PCL failed");
}

std::size_t ReadPclPcd(const std::string& path) {
  PclCloud cloud;
  BACKSIGHT_CHECK(pcl::PCDReader().read(path, cloud) == 0, "PCL failed");
  return cloud.size();
}

std::size_t ReadPclPly(const std::string& path) {
  PclCloud cloud;
  BACKSIGHT_CHECK(pcl::PLYReader().read(path, cloud) == 0, "PCL failed");
  return cloud.size();
}

}  // namespace backsight
