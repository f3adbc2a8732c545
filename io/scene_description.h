#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace backsight {

/// What a synthetic campaign is made of. Positions are metres in the world frame (z up, x east);
/// plan positions are (x, y), and every height counts from the ground at that place. Headings are
/// degrees, counter-clockwise from the x axis. Details that are not stated here (window sizes,
/// leaves, where people stand) are drawn from the scene's seed.

/// A raised strip, such as a pavement; its edges are the kerbs.
struct Kerb {
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
  double width_m = 2.0;
  double height_m = 0.12;
};

struct Ground {
  double size_m = 120.0;                                ///< edge of the square about the origin
  Eigen::Vector2d slope_deg = Eigen::Vector2d::Zero();  ///< rise along x and along y
  double undulation_m = 0.0;                            ///< largest departure from the slope
  std::vector<Kerb> kerbs;
};

enum class FacadeStyle { kMasonry, kModern, kIndustrial };
enum class RoofShape { kFlat, kGable, kHip };

struct Building {
  Eigen::Vector2d center_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d size_m = Eigen::Vector2d(12.0, 10.0);  ///< along the heading, across it
  double heading_deg = 0.0;
  double wall_height_m = 9.0;
  int storeys = 3;
  FacadeStyle style = FacadeStyle::kMasonry;
  RoofShape roof = RoofShape::kGable;
  double bay_m = 3.0;           ///< spacing of window axes
  double window_depth_m = 0.2;  ///< recess of the glass behind the wall
  double arcade_depth_m = 0.0;  ///< passage behind arches on the front (right of the heading)
  int doors = 1;                ///< on the front
  bool repeat = false;          ///< all bays identical, no doors and no irregular details
};

struct Pole {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double height_m = 6.0;
  double diameter_m = 0.14;
  double heading_deg = 0.0;  ///< of the lamp's arm
  bool lamp = true;
};

struct Tree {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double height_m = 8.0;
  double crown_radius_m = 2.2;
  int leaves = 6000;
};

struct Car {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double heading_deg = 0.0;
  double length_m = 4.4;
};

enum class BarrierKind { kWall, kFence };

struct Barrier {
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
  BarrierKind kind = BarrierKind::kWall;
  double height_m = 1.8;
  double thickness_m = 0.25;
};

/// A room or hall, seen from inside. Furniture stands in places drawn from the seed; where a core
/// leaves a ring corridor only, it stands along the walls.
struct Room {
  Eigen::Vector2d center_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d size_m = Eigen::Vector2d(20.0, 12.0);
  double heading_deg = 0.0;
  double height_m = 5.0;
  double bay_m = 4.0;             ///< spacing of windows and doors
  double pillar_spacing_m = 0.0;  ///< 0: no pillars
  double pillar_size_m = 0.4;
  int doors = 2;
  int machines = 0;
  int tables = 0;
  int shelves = 0;
  bool repeat = false;                               ///< all bays and pillars identical, no doors
  Eigen::Vector2d core_m = Eigen::Vector2d::Zero();  ///< closed block in the middle; 0: none
};

/// Walking people: every scan sees them in other places.
struct People {
  int count = 0;
  Eigen::Vector2d min_m = Eigen::Vector2d(-10.0, -10.0);  ///< corner of the area they walk in
  Eigen::Vector2d max_m = Eigen::Vector2d(10.0, 10.0);
};

/// Cars that pass along a lane: every scan sees them in other places of it.
struct Traffic {
  int count = 0;
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();  ///< the lane's axis, in driving direction
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
};

struct StationSite {
  std::string id;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double height_m = 1.7;     ///< of the scanner's centre
  double heading_deg = 0.0;  ///< used where the orientation is levelled
};

enum class Orientation {
  kLevelled,       ///< the site's heading, vertical axis up to the levelling error
  kRandomHeading,  ///< any heading, vertical axis up to the levelling error
  kRandomSo3,      ///< any orientation of the whole instrument
};

/// A scanner that measures on a grid of equal angular steps, so that the point density on a surface
/// falls with the square of the range.
struct Scanner {
  double step_deg = 0.2;
  double min_elevation_deg = -60.0;  ///< the tripod hides what is below
  double max_elevation_deg = 90.0;
  double min_range_m = 0.5;
  double max_range_m = 120.0;          ///< to a surface of 10 % reflectance at normal incidence
  double range_sigma_m = 0.002;        ///< constant part of the range noise
  double range_sigma_ppm = 0.0;        ///< part that grows with range, 1e-6
  double beam_diameter_m = 0.004;      ///< at the instrument
  double beam_divergence_deg = 0.017;  ///< full angle
  bool mixed_pixels = true;            ///< a footprint on several surfaces gives one blended range
  double mixing_m = 0.5;               ///< echoes farther apart than this are told apart
  double dropout = 0.0;                ///< share of returns that are lost at random
  double level_sigma_deg = 0.005;
  Orientation orientation = Orientation::kRandomHeading;
};

/// A surveyed target. Its coordinates are given in the survey frame of the truth.
struct ControlSite {
  std::string id;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< world x, y and height above ground
  double sigma_m = 0.002;                                ///< of each surveyed coordinate
  double measured_sigma_m = 0.001;  ///< of each coordinate as a scanner measures the target
  bool check = false;               ///< a check point: never used for fitting
};

/// Where the scene's world lies on Earth: x, y and z of the world are east, north and up at the
/// origin, turned about the vertical.
struct SceneCrs {
  std::string horizontal;  ///< as in CrsSpec of a project file
  std::string vertical;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< easting, northing, height of the world's 0
  double heading_deg = 0.0;                          ///< of the world's x axis, north of east
};

enum class CampaignFormat { kPtx, kPly, kLas };

struct Scene {
  std::string name = "campaign";  ///< also of the project file written for it
  std::uint64_t seed = 1;
  CampaignFormat format = CampaignFormat::kPtx;
  Ground ground;
  std::vector<Building> buildings;
  std::vector<Room> rooms;
  std::vector<Barrier> barriers;
  std::vector<Pole> poles;
  std::vector<Tree> trees;
  std::vector<Car> cars;
  People people;
  std::vector<Traffic> traffic;
  Scanner scanner;
  std::vector<StationSite> stations;
  std::vector<ControlSite> control;
  std::optional<SceneCrs> crs;  ///< absent: control is given in the world's own coordinates
};

}  // namespace backsight
