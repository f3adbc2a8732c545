#include "stages/simulation/scanner_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include "stages/simulation/echo.h"

namespace backsight {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kDetection = 0.1;  // reflectance that is just seen at the largest range
constexpr double kMinCos = 0.2;
constexpr double kPaneShare = 0.06;    // of pulses on glass that return from the pane
constexpr double kBehindShare = 0.38;  // that return from what lies behind
constexpr double kGlassTransmission = 0.7;
constexpr double kRingShare = 0.7;  // radius of the outer sub-rays, share of the beam's

/// Random numbers of one ray (SplitMix64, Steele et al. 2014, doi 10.1145/2660193.2660195): cheap
/// to seed, which an engine with a large state is not.
class RayRandom {
 public:
  RayRandom(std::uint64_t seed, std::uint64_t ray) : state_(seed ^ Mix(ray + kIncrement)) {}

  double Uniform() {
    state_ += kIncrement;
    return static_cast<double>(Mix(state_) >> 11U) * 0x1.0p-53;
  }
  double Normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * Uniform());
  }

 private:
  static constexpr std::uint64_t kIncrement = 0x9E3779B97F4A7C15U;
  static std::uint64_t Mix(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }
  std::uint64_t state_;
};

RayBundle MakeBeam(const Eigen::Vector3d& origin, const Eigen::Vector3d& axis,
                   const Scanner& scanner) {
  RayBundle beam;
  beam.origins[0] = origin;
  beam.directions[0] = axis;
  beam.count = scanner.mixed_pixels ? RayBundle::kSize : 1;
  const Eigen::Vector3d u = axis.unitOrthogonal();
  const Eigen::Vector3d v = axis.cross(u);
  const double start = kRingShare * 0.5 * scanner.beam_diameter_m;
  const double spread = kRingShare * std::tan(0.5 * scanner.beam_divergence_deg * kRadians);
  for (std::size_t i = 1; i < beam.count; ++i) {
    const double angle =
        2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(beam.count - 1);
    const Eigen::Vector3d side = std::cos(angle) * u + std::sin(angle) * v;
    beam.origins[i] = origin + start * side;
    beam.directions[i] = (axis + spread * side).normalized();
  }
  return beam;
}

/// Measures rays of one station; holds what they share.
class StationScanner {
 public:
  StationScanner(const RayCaster& caster, const RigidTransform& world_from_station,
                 const Scanner& scanner, std::uint64_t seed)
      : caster_(caster), world_from_station_(world_from_station), scanner_(scanner), seed_(seed) {}

  /// Fills record `index` of the scan; false if nothing came back.
  bool Measure(const Eigen::Vector3d& direction, std::size_t index, StationScan& scan) const {
    PointChunk& grid = scan.grid;
    RayRandom random(seed_, index);
    const RayBundle beam = MakeBeam(world_from_station_.translation,
                                    world_from_station_.rotation * direction, scanner_);
    const Echo echo = Receive(beam, random);
    if (!IsDetected(echo) || random.Uniform() < scanner_.dropout) return false;
    const double range =
        echo.range_m + RangeSigma(scanner_, echo.range_m, echo.cos_incidence) * random.Normal();
    if (range < scanner_.min_range_m || range > scanner_.max_range_m) return false;
    grid.x[index] = range * direction.x();
    grid.y[index] = range * direction.y();
    grid.z[index] = range * direction.z();
    const Material& material = caster_.material(echo.material);
    scan.moving[index] = material.moving ? 1 : 0;
    const double falloff = 1.0 + std::pow(echo.range_m / 30.0, 2);
    const double shine = material.reflectance * echo.cos_incidence / falloff;
    grid.intensity[index] =
        static_cast<float>(std::clamp(shine * (1.0 + 0.03 * random.Normal()), 0.0, 1.0));
    for (std::size_t i = 0; i < 3; ++i) {
      grid.rgb[index][i] = static_cast<std::uint16_t>(std::lround(65535.0 * material.rgb[i]));
    }
    return true;
  }

 private:
  Echo Receive(const RayBundle& beam, RayRandom& random) const {
    RayHits hits = caster_.Cast(beam, scanner_.max_range_m, false);
    const auto on_glass = [&](const RayHit& hit) {
      return hit.range_m > 0.0 && caster_.material(hit.material).glass;
    };
    double transmission = 1.0;
    if (std::any_of(hits.begin(), hits.end(), on_glass)) {
      const double fate = random.Uniform();
      if (fate > kPaneShare + kBehindShare) {
        for (RayHit& hit : hits) {
          if (on_glass(hit)) hit = RayHit{};
        }
      } else if (fate > kPaneShare) {
        hits = caster_.Cast(beam, scanner_.max_range_m, true);
        transmission = kGlassTransmission;
      }
    }
    Echo echo = BlendEchoes(beam, hits, caster_, scanner_.mixing_m);
    echo.signal *= transmission;
    return echo;
  }

  bool IsDetected(const Echo& echo) const {
    return echo.range_m >= scanner_.min_range_m &&
           echo.signal * scanner_.max_range_m * scanner_.max_range_m >= kDetection;
  }

  const RayCaster& caster_;
  const RigidTransform& world_from_station_;
  const Scanner& scanner_;
  std::uint64_t seed_;
};

}  // namespace

ScanGridSize GridSize(const Scanner& scanner) {
  const double span = scanner.max_elevation_deg - scanner.min_elevation_deg;
  return {static_cast<int>(std::floor(span / scanner.step_deg + 1e-9)) + 1,
          static_cast<int>(std::lround(360.0 / scanner.step_deg))};
}

double RangeSigma(const Scanner& scanner, double range_m, double cos_incidence) {
  const double growing = 1e-6 * scanner.range_sigma_ppm * range_m;
  return std::hypot(scanner.range_sigma_m, growing) / std::max(kMinCos, cos_incidence);
}

StationScan MeasureStation(const RayCaster& caster, const RigidTransform& world_from_station,
                           const Scanner& scanner, std::uint64_t seed,
                           const ExecutionContext& execution) {
  const ScanGridSize size = GridSize(scanner);
  const auto rows = static_cast<std::size_t>(size.rows);
  const auto columns = static_cast<std::size_t>(size.columns);
  StationScan scan;
  scan.rows = size.rows;
  scan.columns = size.columns;
  for (auto* axis : {&scan.grid.x, &scan.grid.y, &scan.grid.z}) axis->assign(rows * columns, 0.0);
  scan.grid.intensity.assign(rows * columns, 0.0F);
  scan.grid.rgb.assign(rows * columns, {0, 0, 0});
  scan.moving.assign(rows * columns, 0);

  const StationScanner station(caster, world_from_station, scanner, seed);
  std::atomic<std::uint64_t> returns = 0;
  const auto measure_column = [&](std::size_t column) {
    execution.CheckStop();
    const double azimuth =
        2.0 * std::numbers::pi * static_cast<double>(column) / static_cast<double>(columns);
    std::uint64_t seen = 0;
    for (std::size_t row = 0; row < rows; ++row) {
      const double elevation =
          kRadians * (scanner.min_elevation_deg + scanner.step_deg * static_cast<double>(row));
      const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                      std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      if (station.Measure(direction, column * rows + row, scan)) ++seen;
    }
    returns += seen;
  };
  execution.ParallelFor(columns, measure_column, 8);
  scan.returns = returns;
  return scan;
}

}  // namespace backsight
