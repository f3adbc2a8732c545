#include "stages/simulation/ground_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"

namespace backsight {
namespace {

constexpr double kCell = 1.0;

void AddStrip(const Kerb& kerb, const GroundModel& model, MaterialId material, TriangleMesh& mesh) {
  const Eigen::Vector2d along = kerb.to_m - kerb.from_m;
  const Eigen::Vector2d across =
      0.5 * kerb.width_m * Eigen::Vector2d(-along.y(), along.x()).normalized();
  const int steps = std::max(1, static_cast<int>(std::ceil(along.norm() / kCell)));
  const auto at = [&](int step, double side, double height) -> Eigen::Vector3d {
    const Eigen::Vector2d place = kerb.from_m + along * step / steps + side * across;
    return {place.x(), place.y(), model.BaseHeight(place) + height};
  };
  constexpr double kBuried = -0.3;
  for (int i = 0; i < steps; ++i) {
    AddQuad(at(i, -1.0, kerb.height_m), at(i + 1, -1.0, kerb.height_m),
            at(i + 1, 1.0, kerb.height_m), at(i, 1.0, kerb.height_m), material, mesh);
    for (const double side : {-1.0, 1.0}) {
      AddQuad(at(i, side, kBuried), at(i + 1, side, kBuried), at(i + 1, side, kerb.height_m),
              at(i, side, kerb.height_m), material, mesh);
    }
  }
  for (const int end : {0, steps}) {
    AddQuad(at(end, -1.0, kBuried), at(end, 1.0, kBuried), at(end, 1.0, kerb.height_m),
            at(end, -1.0, kerb.height_m), material, mesh);
  }
}

bool Covers(const Kerb& kerb, const Eigen::Vector2d& place) {
  const Eigen::Vector2d along = kerb.to_m - kerb.from_m;
  const Eigen::Vector2d unit = along.normalized();
  const Eigen::Vector2d offset = place - kerb.from_m;
  const double s = offset.dot(unit);
  const double side = unit.x() * offset.y() - unit.y() * offset.x();
  return s >= 0.0 && s <= along.norm() && std::abs(side) <= 0.5 * kerb.width_m;
}

}  // namespace

GroundModel::GroundModel(const Ground& ground, std::uint64_t seed)
    : ground_(ground),
      slope_((ground.slope_deg * std::numbers::pi / 180.0).array().tan().matrix()) {
  Random random(DeriveSeed(seed, "ground"));
  for (Wave& wave : waves_) {
    const double length = random.Uniform(12.0, 35.0);
    const double heading = random.Uniform(0.0, 2.0 * std::numbers::pi);
    wave.frequency =
        2.0 * std::numbers::pi / length * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    wave.phase = random.Uniform(0.0, 2.0 * std::numbers::pi);
  }
}

double GroundModel::BaseHeight(const Eigen::Vector2d& place) const {
  double height = slope_.dot(place);
  for (const Wave& wave : waves_) {
    height += ground_.undulation_m / static_cast<double>(waves_.size()) *
              std::sin(wave.frequency.dot(place) + wave.phase);
  }
  return height;
}

double GroundModel::Height(const Eigen::Vector2d& place) const {
  double strip = 0.0;
  for (const Kerb& kerb : ground_.kerbs) {
    if (Covers(kerb, place)) strip = std::max(strip, kerb.height_m);
  }
  return BaseHeight(place) + strip;
}

void AddGround(const Ground& ground, const GroundModel& model, MaterialId surface, MaterialId strip,
               TriangleMesh& mesh) {
  const int cells = static_cast<int>(std::ceil(ground.size_m / kCell));
  const auto at = [&](int i, int j) -> Eigen::Vector3d {
    const Eigen::Vector2d place =
        ground.size_m * (Eigen::Vector2d(i, j) / cells).array() - 0.5 * ground.size_m;
    return {place.x(), place.y(), model.BaseHeight(place)};
  };
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      AddQuad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), surface, mesh);
    }
  }
  for (const Kerb& kerb : ground.kerbs) AddStrip(kerb, model, strip, mesh);
}

}  // namespace backsight
