#include "tests/support/town_scene.h"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "core/random.h"

namespace backsight {
namespace {

constexpr double kPitchX = 32.0;  // metres from street to street
constexpr double kPitchY = 28.0;
constexpr double kStreet = 10.0;

class TownWriter {
 public:
  explicit TownWriter(const TownScene& town) : town_(town), random_(town.seed) {}

  std::string Write() {
    for (int row = 0; row < town_.rows; ++row) {
      for (int column = 0; column < town_.columns; ++column) Block(column, row);
    }
    // Houses around the town, so that the streets at its edge have two sides.
    for (int column = 0; column < town_.columns; ++column) {
      Edge(X(column) + kPitchX / 2, Y(0) - kStreet / 2 - 5.5, kPitchX);
      Edge(X(column) + kPitchX / 2, Y(town_.rows) + kStreet / 2 + 5.5, kPitchX);
    }
    for (int i = 0; i <= town_.columns; ++i) {
      for (int j = 0; j <= town_.rows; ++j) Crossing(i, j);
    }
    const double size = 60.0 + std::max(town_.columns * kPitchX, town_.rows * kPitchY);
    return fmt::format(
        "schema_version: 1\nname: town\nseed: {}\nformat: ply\n"
        "ground: {{size_m: {}, slope_deg: [0.3, -0.2], undulation_m: 0.15}}\n"
        "buildings:\n{}poles:\n{}trees:\n{}cars:\n{}"
        "scanner: {{step_deg: {}, min_elevation_deg: -55, max_elevation_deg: 60, max_range_m: 60,\n"
        "          range_sigma_m: 0.002, dropout: 0.01, orientation: random_heading}}\n"
        "stations:\n{}",
        town_.seed, size, buildings_, poles_, trees_, cars_, town_.step_deg, stations_);
  }

 private:
  double X(int column) const { return (column - town_.columns / 2.0) * kPitchX; }
  double Y(int row) const { return (row - town_.rows / 2.0) * kPitchY; }

  void Building(double x, double y, double length, double depth, double heading) {
    static constexpr std::array<const char*, 3> kStyles = {"masonry", "modern", "industrial"};
    static constexpr std::array<const char*, 3> kRoofs = {"flat", "gable", "hip"};
    const int storeys = 1 + static_cast<int>(random_.Index(4));
    buildings_ += fmt::format(
        "  - {{center_m: [{:.3f}, {:.3f}], size_m: [{:.2f}, {:.2f}], heading_deg: {:.2f}, "
        "wall_height_m: {:.2f}, storeys: {}, style: {}, roof: {}, bay_m: {:.2f}, "
        "window_depth_m: {:.2f}, doors: {}}}\n",
        x, y, length, depth, heading + random_.Uniform(-2.0, 2.0),
        3.1 * storeys + random_.Uniform(0.2, 1.5), storeys, kStyles.at(random_.Index(3)),
        kRoofs.at(random_.Index(3)), random_.Uniform(2.4, 4.8), random_.Uniform(0.12, 0.35),
        random_.Index(3));
  }

  /// Two rows of two or three houses, with gaps between them.
  void Block(int column, int row) {
    const double left = X(column) + kStreet / 2;
    const double width = kPitchX - kStreet;
    for (const int side : {0, 1}) {
      const int houses = 2 + static_cast<int>(random_.Index(2));
      for (int h = 0; h < houses; ++h) {
        const double plot = width / houses;
        const double length = plot - random_.Uniform(0.8, 3.5);
        const double depth = random_.Uniform(6.0, 7.6);
        const double setback = random_.Uniform(0.0, 1.2);
        const double x = left + plot * (h + 0.5);
        const double y = side == 0 ? Y(row) + kStreet / 2 + setback + depth / 2
                                   : Y(row + 1) - kStreet / 2 - setback - depth / 2;
        Building(x, y, length, depth, side == 0 ? 0.0 : 180.0);
      }
    }
  }

  void Edge(double x, double y, double plot) {
    const double length = plot - random_.Uniform(6.0, 20.0);
    Building(x + random_.Uniform(-3.0, 3.0), y, length, 10.0, 0.0);
  }

  void Station(double x, double y) {
    stations_ +=
        fmt::format("  - {{id: T{:03d}, position_m: [{:.3f}, {:.3f}], height_m: {:.2f}}}\n",
                    ++count_, x + random_.Uniform(-2.0, 2.0), y + random_.Uniform(-2.0, 2.0),
                    random_.Uniform(1.55, 1.85));
  }

  void Crossing(int i, int j) {
    const double x = X(i);
    const double y = Y(j);
    Station(x, y);
    if (i < town_.columns) Station(x + kPitchX / 2, y);
    if (j < town_.rows) Station(x, y + kPitchY / 2);
    poles_ += fmt::format(
        "  - {{position_m: [{:.2f}, {:.2f}], height_m: {:.2f}, heading_deg: {:.0f}, lamp: {}}}\n",
        x + random_.Uniform(3.4, 4.6), y + random_.Uniform(-9.0, 9.0), random_.Uniform(2.5, 7.5),
        random_.Uniform(0.0, 360.0), random_.Index(2) == 0);
    for (std::uint64_t car = 0; car < 1 + random_.Index(3); ++car) {
      cars_ += fmt::format(
          "  - {{position_m: [{:.2f}, {:.2f}], heading_deg: {:.1f}, length_m: {:.2f}}}\n",
          x + 7.0 + 6.0 * static_cast<double>(car) + random_.Uniform(0.0, 1.0),
          y + random_.Uniform(3.2, 3.8), random_.Uniform(-4.0, 4.0), random_.Uniform(3.7, 5.0));
    }
    if (random_.Index(2) == 0) {
      trees_ += fmt::format(
          "  - {{position_m: [{:.2f}, {:.2f}], height_m: {:.2f}, crown_radius_m: {:.2f}, "
          "leaves: 3000}}\n",
          x - random_.Uniform(3.2, 4.4), y + random_.Uniform(7.0, 14.0), random_.Uniform(4.5, 9.0),
          random_.Uniform(1.1, 2.0));
    }
  }

  TownScene town_;
  Random random_;
  int count_ = 0;
  std::string buildings_;
  std::string poles_;
  std::string trees_;
  std::string cars_;
  std::string stations_;
};

}  // namespace

int StationCount(const TownScene& town) {
  return (town.columns + 1) * (town.rows + 1) + town.columns * (town.rows + 1) +
         (town.columns + 1) * town.rows;
}

std::string SceneYaml(const TownScene& town) { return TownWriter(town).Write(); }

}  // namespace backsight
