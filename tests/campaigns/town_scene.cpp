#include "tests/campaigns/town_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/random.h"

namespace backsight {
namespace {

constexpr int kBlocks = 5;  // along each axis
constexpr double kBlockSize = 58.0;
constexpr std::size_t kStations = 200;

using Place = Eigen::Vector2d;

struct Street {
  Place from;
  Place to;
  double half_width = 5.0;  // to the facades, pavements included

  double length() const { return (to - from).norm(); }
  Place along() const { return (to - from) / length(); }
  Place left() const { return {-along().y(), along().x()}; }
  double heading_deg() const {
    return std::atan2(along().y(), along().x()) * 180.0 / std::numbers::pi;
  }
};

class TownBuilder {
 public:
  explicit TownBuilder(std::uint64_t seed) : random_(DeriveSeed(seed, "town")) {
    scene_.name = "town";
    scene_.seed = seed;
    scene_.format = CampaignFormat::kPly;
    scene_.ground.size_m = kBlocks * kBlockSize + 90.0;
    scene_.ground.slope_deg = {random_.Uniform(-0.8, 0.8), random_.Uniform(-0.8, 0.8)};
    scene_.ground.undulation_m = 0.4;
    scene_.scanner.step_deg = 0.8;
    scene_.scanner.min_elevation_deg = -45.0;
    scene_.scanner.max_elevation_deg = 55.0;
    scene_.scanner.max_range_m = 60.0;
    scene_.scanner.dropout = 0.01;
  }

  Scene Build() {
    DrawNodes();
    DrawStreets();
    DrawSquares();
    for (const Street& street : streets_) Furnish(street);
    for (int i = 0; i < kBlocks; ++i) {
      for (int j = 0; j < kBlocks; ++j) AddBlock(i, j);
    }
    AddOutskirts();
    PlaceStations();
    const double half = 0.5 * kBlocks * kBlockSize;
    scene_.people = {150, {-half, -half}, {half, half}};
    return scene_;
  }

 private:
  static constexpr int kNodes = kBlocks + 1;

  const Place& Node(int i, int j) const { return nodes_[static_cast<std::size_t>(i * kNodes + j)]; }
  bool IsSquare(int i, int j) const {
    return std::find(squares_.begin(), squares_.end(), std::array<int, 2>{i, j}) != squares_.end();
  }

  void DrawNodes() {
    for (int i = 0; i < kNodes; ++i) {
      for (int j = 0; j < kNodes; ++j) {
        const double x = (i - 0.5 * kBlocks) * kBlockSize + random_.Uniform(-8.0, 8.0);
        const double y = (j - 0.5 * kBlocks) * kBlockSize + random_.Uniform(-8.0, 8.0);
        nodes_.push_back({x, y});
      }
    }
  }

  void DrawStreets() {
    for (int i = 0; i < kNodes; ++i) {
      for (int j = 0; j < kNodes; ++j) {
        if (i < kBlocks) streets_.push_back({Node(i, j), Node(i + 1, j), HalfWidth()});
        if (j < kBlocks) streets_.push_back({Node(i, j), Node(i, j + 1), HalfWidth()});
      }
    }
  }
  double HalfWidth() { return random_.Uniform(4.0, 7.5); }

  void DrawSquares() {
    while (squares_.size() < 2) {
      const int i = 1 + static_cast<int>(random_.Index(kBlocks - 2));
      const int j = 1 + static_cast<int>(random_.Index(kBlocks - 2));
      if (!IsSquare(i, j)) squares_.push_back({i, j});
    }
  }

  /// Pavements, parked cars, lamps, signs and trees, all between the crossings.
  void Furnish(const Street& street) {
    constexpr double kCrossing = 8.0;
    const auto at = [&](double s, double side) -> Place {
      return street.from + s * street.along() + side * street.left();
    };
    const double end = street.length() - kCrossing;
    for (const double side : {-1.0, 1.0}) {
      const double pavement = side * (street.half_width - 0.9);
      scene_.ground.kerbs.push_back({at(kCrossing, pavement), at(end, pavement), 1.8, 0.12});
      const double lane = side * (street.half_width - 2.9);
      const double edge = side * (street.half_width - 1.5);
      for (double s = kCrossing + 3.0; s < end - 3.0; s += random_.Uniform(5.5, 14.0)) {
        const double heading = street.heading_deg() + random_.Uniform(-3.0, 3.0);
        if (street.half_width > 5.5 && random_.Uniform() < 0.6) {
          scene_.cars.push_back({at(s, lane), heading, random_.Uniform(3.8, 4.9)});
        }
      }
      for (double s = kCrossing; s < end; s += random_.Uniform(10.0, 30.0)) {
        Pole pole;
        pole.position_m = at(s, edge);
        pole.height_m = random_.Uniform(2.2, 6.5);
        pole.diameter_m = random_.Uniform(0.08, 0.25);
        pole.heading_deg = street.heading_deg() - 90.0 * side;
        pole.lamp = pole.height_m > 4.5;
        scene_.poles.push_back(pole);
      }
      if (street.half_width > 6.0) AddTree(at(random_.Uniform(12.0, end), edge));
    }
  }

  void AddTree(const Place& place) {
    const double height = random_.Uniform(4.5, 9.0);
    scene_.trees.push_back({place, height, 0.26 * height, 700});
  }

  void AddBlock(int i, int j) {
    const std::array<Place, 4> corners = {Node(i, j), Node(i + 1, j), Node(i + 1, j + 1),
                                          Node(i, j + 1)};
    if (IsSquare(i, j)) {
      const Place middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
      for (int k = 0; k < 7; ++k) {
        const double x = random_.Uniform(-14.0, 14.0);
        AddTree(middle + Place(x, random_.Uniform(-14.0, 14.0)));
      }
      return;
    }
    for (std::size_t side = 0; side < 4; ++side) {
      // Houses of every other side go round the corner; those between keep clear of them.
      const double margin = side % 2 == 0 ? 8.5 : 21.0;
      AddRow(corners[side], corners[(side + 1) % 4], margin);
    }
  }

  /// Houses to the left of the street from one crossing to the next.
  void AddRow(const Place& from, const Place& to, double margin) {
    const Street street = StreetBetween(from, to);
    double s = margin;
    const double end = street.length() - margin;
    while (s < end - 6.0) {
      const double front = std::min(random_.Uniform(8.0, 17.0), end - s);
      if (random_.Uniform() < 0.92) AddHouse(street, s + 0.5 * front, front);
      s += front + (random_.Uniform() < 0.25 ? random_.Uniform(1.5, 5.0) : 0.05);
    }
  }

  Street StreetBetween(const Place& from, const Place& to) const {
    for (const Street& street : streets_) {
      if ((street.from == from && street.to == to) || (street.from == to && street.to == from)) {
        return {from, to, street.half_width};
      }
    }
    return {from, to};
  }

  void AddHouse(const Street& street, double s, double front) {
    Building house;
    const double depth = random_.Uniform(8.5, 11.0);
    const double setback = random_.Uniform(0.0, 0.4);
    house.center_m = street.from + s * street.along() +
                     (street.half_width + setback + 0.5 * depth) * street.left();
    house.size_m = {front, depth};
    house.heading_deg = street.heading_deg() + random_.Uniform(-1.5, 1.5);
    house.storeys = 2 + static_cast<int>(random_.Index(3));
    house.wall_height_m = house.storeys * random_.Uniform(2.8, 3.5);
    house.style = static_cast<FacadeStyle>(random_.Index(3));
    house.roof = static_cast<RoofShape>(random_.Index(3));
    house.bay_m = random_.Uniform(2.5, 4.5);
    house.window_depth_m = random_.Uniform(0.12, 0.35);
    scene_.buildings.push_back(house);
  }

  /// The far sides of the outermost streets.
  void AddOutskirts() {
    for (int k = 0; k < kBlocks; ++k) {
      AddRow(Node(k + 1, 0), Node(k, 0), 8.5);
      AddRow(Node(k, kBlocks), Node(k + 1, kBlocks), 8.5);
      AddRow(Node(0, k), Node(0, k + 1), 8.5);
      AddRow(Node(kBlocks, k + 1), Node(kBlocks, k), 8.5);
    }
  }

  std::vector<Place> Candidates(double spacing) const {
    std::vector<Place> places = nodes_;
    for (const Street& street : streets_) {
      const int parts = std::max(1, static_cast<int>(std::lround(street.length() / spacing)));
      for (int k = 1; k < parts; ++k) {
        const double offset = (k % 2 == 0 ? 0.2 : -0.2) * street.half_width;
        places.push_back(street.from + (street.to - street.from) * k / parts +
                         offset * street.left());
      }
    }
    for (const auto& [i, j] : squares_) {
      const Place middle =
          0.25 * (Node(i, j) + Node(i + 1, j) + Node(i + 1, j + 1) + Node(i, j + 1));
      for (const Place& corner : {Place(-9, -9), Place(9, -9), Place(9, 9), Place(-9, 9)}) {
        places.push_back(middle + corner);
      }
    }
    return places;
  }

  void PlaceStations() {
    double spacing = 30.0;
    while (Candidates(spacing).size() < kStations) spacing -= 0.2;
    std::vector<Place> places = Candidates(spacing);
    while (places.size() > kStations) {
      // Crossings and squares stay; single places along the streets go.
      const std::size_t streets = places.size() - nodes_.size() - 4 * squares_.size();
      const auto at = static_cast<std::ptrdiff_t>(nodes_.size() + random_.Index(streets));
      places.erase(places.begin() + at);
    }
    for (const Place& place : places) {
      StationSite site;
      site.id = fmt::format("S{}", scene_.stations.size() + 1);
      const double x = random_.Uniform(-0.8, 0.8);
      site.position_m = place + Place(x, random_.Uniform(-0.8, 0.8));
      site.height_m = random_.Uniform(1.55, 1.8);
      scene_.stations.push_back(site);
    }
    const auto in_the_way = [&](const Place& object) {
      return std::any_of(
          scene_.stations.begin(), scene_.stations.end(),
          [&](const StationSite& site) { return (site.position_m - object).norm() < 3.0; });
    };
    std::erase_if(scene_.cars, [&](const Car& car) { return in_the_way(car.position_m); });
    std::erase_if(scene_.trees, [&](const Tree& tree) { return in_the_way(tree.position_m); });
    std::erase_if(scene_.poles, [&](const Pole& pole) { return in_the_way(pole.position_m); });
  }

  Random random_;
  Scene scene_;
  std::vector<Place> nodes_;
  std::vector<Street> streets_;
  std::vector<std::array<int, 2>> squares_;
};

}  // namespace

Scene Town(std::uint64_t seed) { return TownBuilder(seed).Build(); }

}  // namespace backsight
