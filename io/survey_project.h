#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/option_visitor.h"
#include "core/rigid_transform.h"
#include "io/text_columns.h"

namespace backsight {

/// Where a station is believed to be, from GNSS, a sketch or an earlier survey.
struct StationPrior {
  RigidTransform survey_from_station;
  double sigma_m = 1.0;
  double sigma_deg = 5.0;
};

struct StationSpec {
  std::string id;                 ///< fit for file names; unique
  std::string scan;               ///< path of the scan file
  int scan_index = 0;             ///< which scan of the file, from 0
  bool levelled = false;          ///< the instrument was levelled: z of the station frame is up
  double level_sigma_deg = 0.01;  ///< how well; per horizontal axis
  std::optional<StationPrior> prior;
  /// Position of the instrument in the scan's own coordinates, metres; needed only for scans that
  /// are not in their scanner's frame.
  std::optional<Eigen::Vector3d> scanner_origin_m;
  TextColumns columns;  ///< of a text scan (XYZ, PTS); empty: guessed from its values
};

/// Names of EPSG or another authority, "EPSG:25832".
struct CrsSpec {
  std::string horizontal;
  std::string vertical;  ///< empty: none
};

/// Where a station saw a survey point.
struct ControlMeasurement {
  std::string station;
  Eigen::Vector3d xyz_m = Eigen::Vector3d::Zero();  ///< station frame
};

struct ControlPoint {
  enum class Role { kControl, kCheck };
  std::string id;
  Eigen::Vector3d crs_m = Eigen::Vector3d::Zero();  ///< easting, northing, height
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  Role role = Role::kControl;
  std::vector<ControlMeasurement> measured;
};

/// Pairs of station ids in no particular order of the two.
struct PairSpec {
  std::vector<std::pair<std::string, std::string>> include;  ///< tried in any case
  std::vector<std::pair<std::string, std::string>> exclude;  ///< never tried
};

enum class CloudFormat { kLas, kPly, kPcd, kE57 };

/// Points of a merged cloud outside are left out; in the coordinates that outputs are in.
struct CropBox {
  Eigen::Vector3d min = Eigen::Vector3d::Zero();
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
};

struct CloudOutput {
  CloudFormat format = CloudFormat::kLas;
  std::string path;             ///< a file for a merged cloud, a folder for station clouds
  double thin_m = 0.0;          ///< keep the best point per cell of this edge; 0: all points
  int max_points = 0;           ///< LAS: more points go into numbered files; 0: always one file
  std::optional<CropBox> crop;  ///< merged clouds only
  bool without_moving = false;  ///< points of what moved are left out, not marked
};

/// An occupancy map as an OctoMap file.
struct MapOutput {
  std::string path;           ///< empty: none is wanted
  double resolution_m = 0.2;  ///< edge of its voxels
};

struct OutputSpec {
  /// Absent: the project file does not say, the caller chooses. Empty: none wanted.
  std::optional<std::vector<CloudOutput>> merged;
  std::optional<CloudOutput> stations;
  std::optional<MapOutput> map;  ///< absent: the caller chooses
};

/// Limits that decide between exit codes 0 and 4; absent: not checked.
struct GateSpec {
  std::optional<double> max_station_sigma_mm;
  std::optional<double> max_check_rmse_mm;
  bool require_all_stations = false;
};

struct ResourceSpec {
  int threads = 0;               ///< 0: all cores
  double memory_gb = 8.0;        ///< of the whole run
  double pair_limit_s = 3600.0;  ///< of one attempt at a pair; 0: none
};

/// A survey project file. Paths are as the program can open them: absolute, or the folder of the
/// project file joined with what is written there.
struct SurveyProject {
  std::string path;
  std::string name;  ///< the file's stem where not given
  std::optional<CrsSpec> crs;
  std::vector<StationSpec> stations;  ///< at least 2
  std::vector<ControlPoint> control;
  PairSpec pairs;
  OutputSpec outputs;
  GateSpec gates;
  ResourceSpec resources;
};

/// What is wrong with a project beyond the form of its file.
struct ProjectFault {
  enum class Place { kCrs, kControl, kPoint, kSighting };
  Place place = Place::kControl;
  std::size_t point = 0;     ///< of kPoint and kSighting: index into SurveyProject::control
  std::size_t sighting = 0;  ///< of kSighting: index into its `measured`
  std::string found;
  std::string expected;
  std::string remedy;
};

/// Which parts of a project were read without a fault; nothing is to be said of the others.
struct WholeParts {
  bool stations = false;
  bool crs = false;  ///< or there is none
  bool control = false;
};

/// Looks for faults that this layer cannot know; the options are filled by then.
using ProjectCheck =
    std::function<std::vector<ProjectFault>(const SurveyProject&, const WholeParts&)>;

/// Reads and validates a survey project file (schema_version 1) and fills the options behind
/// `sections` from its maps of the same names. Throws one InputError that lists everything wrong
/// with the file, line by line, what `check` finds included. A prior's `survey_from_station` is
/// either 16 numbers, a 4x4 matrix by rows, or 7 numbers [x, y, z, qw, qx, qy, qz].
SurveyProject ReadSurveyProject(const std::string& path, const std::vector<OptionSection>& sections,
                                const ProjectCheck& check = {});

/// Where the cloud of a single station goes: a file in outputs.stations' folder.
std::string StationCloudPath(const CloudOutput& output, const std::string& station);

}  // namespace backsight
