#include "tests/support/hall_scene.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/execution.h"
#include "core/voxel_grid.h"

namespace backsight {
namespace {

/// Distance along the ray to a box's near side from outside, to its far side from inside; infinite
/// where it misses.
double Distance(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& from,
                const Eigen::Vector3d& direction) {
  const Eigen::Array3d a = (box.min() - from).array() / direction.array();
  const Eigen::Array3d b = (box.max() - from).array() / direction.array();
  const double enter = a.min(b).maxCoeff();
  const double leave = a.max(b).minCoeff();
  if (leave < std::max(enter, 0.0)) return std::numeric_limits<double>::infinity();
  return enter > 0.0 ? enter : leave;
}

RigidTransform RandomPlace(Random& random, const Eigen::Vector3d& place) {
  const double heading = random.Uniform(0.0, 2.0 * std::numbers::pi);
  return {Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix(), place};
}

StationModel Scan(const HallScene& scene, const RigidTransform& world_from_station,
                  std::uint64_t seed, const HallScan& scan) {
  Random random(DeriveSeed(seed, "noise"));
  const double step = scan.step_deg * std::numbers::pi / 180.0;
  std::vector<Eigen::Vector3d> points;
  for (double elevation = -1.1; elevation < 1.5; elevation += step) {
    for (double azimuth = 0.0; azimuth < 2.0 * std::numbers::pi; azimuth += step) {
      // Off the grid a little: no ray runs exactly along a wall.
      const double e = elevation + 0.2 * step * random.Uniform();
      const Eigen::Vector3d ray(std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth),
                                std::sin(e));
      const Eigen::Vector3d hit =
          scene.Hit(world_from_station.translation, world_from_station.rotation * ray);
      const double range = (hit - world_from_station.translation).norm();
      points.push_back((range + scan.noise_m * random.Normal()) * ray);
    }
  }
  return MakeSeenStation(points, scan.resolution_m);
}

}  // namespace

HallScene::HallScene(std::uint64_t seed, const HallOptions& options)
    : hall_(
          Eigen::Vector3d(-0.5 * options.size_m.x(), -0.5 * options.size_m.y(), 0.0),
          Eigen::Vector3d(0.5 * options.size_m.x(), 0.5 * options.size_m.y(), options.size_m.z())) {
  Random random(DeriveSeed(seed, "boxes"));
  for (int i = 0; i < options.boxes; ++i) {
    const Eigen::Vector2d center(options.size_m.x() * random.Uniform(-0.42, 0.42),
                                 options.size_m.y() * random.Uniform(-0.4, 0.4));
    AddBox(center, {random.Uniform(0.6, 2.0), random.Uniform(0.6, 1.6), random.Uniform(0.8, 1.4)});
  }
}

HallScene HallScene::WithPeople(std::uint64_t seed, int people) const {
  HallScene busy = *this;
  Random random(DeriveSeed(seed, "people"));
  for (int i = 0; i < people; ++i) {
    const Eigen::Vector3d size = hall_.sizes();
    busy.AddBox({size.x() * random.Uniform(-0.45, 0.45), size.y() * random.Uniform(-0.45, 0.45)},
                {0.5, 0.35, 1.75});
  }
  return busy;
}

HallScene HallScene::WithBox(const Eigen::Vector2d& center, const Eigen::Vector3d& size) const {
  HallScene furnished = *this;
  furnished.AddBox(center, size);
  return furnished;
}

Eigen::Vector3d HallScene::Hit(const Eigen::Vector3d& from,
                               const Eigen::Vector3d& direction) const {
  double nearest = Distance(hall_, from, direction);
  for (const Eigen::AlignedBox3d& box : boxes_) {
    if (!box.contains(from)) nearest = std::min(nearest, Distance(box, from, direction));
  }
  return from + nearest * direction;
}

void HallScene::AddBox(const Eigen::Vector2d& center, const Eigen::Vector3d& size) {
  const Eigen::Vector3d low(center.x() - 0.5 * size.x(), center.y() - 0.5 * size.y(), 0.0);
  boxes_.emplace_back(low, low + size);
}

HallStation::HallStation(const HallScene& scene, const Eigen::Vector3d& place, std::uint64_t seed,
                         const HallScan& scan)
    : world_from_station([&] {
        Random random(DeriveSeed(seed, "place"));
        return RandomPlace(random, place);
      }()),
      model(Scan(scene, world_from_station, seed, scan)),
      features(ComputeFeatures(model, {}, ExecutionContext(1, 0, nullptr))),
      index(model) {}

StationModel MakeSeenStation(std::span<const Eigen::Vector3d> points, double resolution_m) {
  StationModel model;
  model.range_image = RangeImage(Eigen::Vector3d::Zero(), 0.25);
  VoxelClusterer clusterer({.edge_m = resolution_m});
  for (const Eigen::Vector3d& point : points) clusterer.Add(point);
  model.leaves = clusterer.Finish();
  for (const Eigen::Vector3d& mean : model.leaves.means()) model.range_image.Add(mean);
  model.points = points.size();
  return model;
}

}  // namespace backsight
