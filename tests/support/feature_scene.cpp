#include "tests/support/feature_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "core/voxel_grid.h"

namespace backsight {
namespace {

constexpr double kResolution = 0.1;
constexpr double kGround = -1.55;  // metres; in the middle of a layer of voxels

class YardScanner {
 public:
  YardScanner(std::uint64_t seed, double size) : random_(seed), size_(size) {}

  std::vector<Eigen::Vector3d> Scan() {
    const double half = 4.45 * std::sqrt(size_);
    const double height = 2.5;
    Rectangle({-half, -half, kGround}, {2 * half, 0, 0}, {0, 2 * half, 0});
    Rectangle({-half, -half, kGround}, {0, 0, height}, {2 * half, 0, 0});
    Rectangle({half, -half, kGround}, {0, 0, height}, {0, 2 * half, 0});
    Rectangle({half, half, kGround}, {0, 0, height}, {-2 * half, 0, 0});
    Rectangle({-half, half, kGround}, {0, 0, height}, {0, -2 * half, 0});
    const int things = static_cast<int>(12.0 * size_);
    for (int i = 0; i < things; ++i) {
      const double azimuth = random_.Uniform(0.0, 2.0 * std::numbers::pi);
      const double range = random_.Uniform(2.0, half - 1.0);
      const Eigen::Vector3d foot(range * std::cos(azimuth), range * std::sin(azimuth), kGround);
      if (i % 2 == 0) {
        Box(foot);
      } else {
        Column(foot, random_.Uniform(0.1, 0.4), random_.Uniform(1.0, 3.0));
      }
    }
    return std::move(points_);
  }

 private:
  /// Measures the point if its surface faces the scanner.
  void Measure(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
    if (normal.dot(point) >= 0.0) return;
    points_.push_back(point + 0.004 * random_.Normal() * point.normalized());
  }

  /// Side a x side b is the normal.
  void Rectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& a,
                 const Eigen::Vector3d& b) {
    const Eigen::Vector3d normal = a.cross(b);
    const auto count = static_cast<int>(3.0 * normal.norm() / (kResolution * kResolution));
    for (int i = 0; i < count; ++i) {
      Measure(corner + random_.Uniform() * a + random_.Uniform() * b, normal);
    }
  }

  void Box(const Eigen::Vector3d& foot) {
    const double turn = random_.Uniform(0.0, std::numbers::pi);
    const Eigen::Vector3d a =
        random_.Uniform(0.4, 1.5) * Eigen::Vector3d(std::cos(turn), std::sin(turn), 0.0);
    const Eigen::Vector3d b =
        random_.Uniform(0.4, 1.5) * Eigen::Vector3d(-std::sin(turn), std::cos(turn), 0.0);
    const Eigen::Vector3d c(0.0, 0.0, random_.Uniform(0.3, 1.4));
    Rectangle(foot, a, c);
    Rectangle(foot + b, c, a);
    Rectangle(foot, c, b);
    Rectangle(foot + a, b, c);
    Rectangle(foot + c, a, b);
  }

  void Column(const Eigen::Vector3d& foot, double radius, double height) {
    const double area = 2.0 * std::numbers::pi * radius * height;
    const auto count = static_cast<int>(3.0 * area / (kResolution * kResolution));
    for (int i = 0; i < count; ++i) {
      const double angle = random_.Uniform(0.0, 2.0 * std::numbers::pi);
      const Eigen::Vector3d normal(std::cos(angle), std::sin(angle), 0.0);
      Measure(foot + radius * normal + Eigen::Vector3d(0, 0, random_.Uniform(0.0, height)), normal);
    }
  }

  Random random_;
  double size_;
  std::vector<Eigen::Vector3d> points_;
};

}  // namespace

std::vector<Eigen::Vector3d> ScanYard(std::uint64_t seed, double size) {
  return YardScanner(seed, size).Scan();
}

StationModel MakeYardStation(std::uint64_t seed, double size) {
  return MakeStation(ScanYard(seed, size), kResolution);
}

StationModel MakeStation(std::span<const Eigen::Vector3d> points, double resolution_m) {
  StationModel model;
  VoxelClusterer clusterer({.edge_m = resolution_m});
  for (const Eigen::Vector3d& point : points) clusterer.Add(point);
  model.leaves = clusterer.Finish();
  model.points = points.size();
  return model;
}

std::vector<Eigen::Vector3f> LeafPositions(const StationModel& model) {
  std::vector<Eigen::Vector3f> positions;
  for (const Eigen::Vector3d& mean : model.leaves.means()) positions.push_back(mean.cast<float>());
  return positions;
}

double MedianRelativeDifference(std::span<const FpfhDescriptor> a,
                                std::span<const FpfhDescriptor> b) {
  std::vector<double> differences;
  for (std::size_t k = 0; k < a.size(); ++k) {
    double difference = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < a[k].size(); ++i) {
      difference += std::pow(static_cast<double>(a[k][i]) - b[k][i], 2);
      norm += std::pow(static_cast<double>(b[k][i]), 2);
    }
    differences.push_back(std::sqrt(difference / norm));
  }
  if (differences.empty()) return 0.0;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return *middle;
}

}  // namespace backsight
