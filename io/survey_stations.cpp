#include "io/survey_stations.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <utility>

#include "core/error.h"
#include "io/nearest_name.h"
#include "io/scan_reader.h"

namespace backsight {
namespace {

// Source IDs of LAS points are 16 bit.
constexpr std::size_t kMaxStations = 65535;
constexpr double kMaxCoordinate = 1e8;
constexpr double kRotationTolerance = 1e-3;

constexpr RealRange kCoordinate{-kMaxCoordinate, kMaxCoordinate, "m"};
constexpr RealRange kSigma{1e-6, 1e6, "m"};
constexpr RealRange kSigmaAngle{1e-6, 180.0, "deg"};

bool IsAlphanumeric(char c) {
  return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

/// Ids become names of files and of pair folders "<a>__<b>", which must stay unambiguous.
bool IsFitForFileNames(const std::string& id) {
  return !id.empty() && id.size() <= 64 && IsAlphanumeric(id.front()) &&
         IsAlphanumeric(id.back()) && id.find("__") == std::string::npos &&
         std::all_of(id.begin(), id.end(),
                     [](char c) { return IsAlphanumeric(c) || c == '_' || c == '-' || c == '.'; });
}

/// Reads an id and remembers its line; `seen` holds those of its kind so far.
std::string ReadId(const YamlValue& value, std::map<std::string, int>& seen) {
  const std::string id = value.Text();
  if (id.empty()) return id;
  if (!IsFitForFileNames(id)) {
    value.Reject(
        "at most 64 letters, digits and single '_', '-', '.' between them, because it names files");
  }
  const auto [it, inserted] = seen.emplace(id, value.line());
  if (!inserted) {
    value.Reject("an id of its own", fmt::format("line {} has the same one", it->second));
    return "";  // whose it is, is not known
  }
  return id;
}

Eigen::Vector3d ReadVector(const YamlValue& value, const RealRange& range) {
  const std::vector<double> v = value.Reals(3, range);
  return {v[0], v[1], v[2]};
}

RigidTransform FromMatrixRows(const YamlValue& value, const std::vector<double>& v) {
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = v[static_cast<std::size_t>(i)];
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  const bool last_row_right = matrix.row(3) == Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0);
  if (!(error < kRotationTolerance) || rotation.determinant() < 0.0 || !last_row_right) {
    value.Reject("a rigid 4x4 matrix by rows: rotation, translation, last row 0, 0, 0, 1", "",
                 "a matrix that is not rigid");
    return {};
  }
  return RigidTransform::FromMatrix(matrix);
}

RigidTransform FromPositionQuaternion(const YamlValue& value, const std::vector<double>& v) {
  const Eigen::Quaterniond q(v[3], v[4], v[5], v[6]);
  if (!(std::abs(q.norm() - 1.0) < kRotationTolerance)) {
    value.Reject("[x, y, z, qw, qx, qy, qz] with a unit quaternion", "",
                 fmt::format("a quaternion of length {:.6g}", q.norm()));
    return {};
  }
  return RigidTransform::FromQuaternion(q, {v[0], v[1], v[2]});
}

RigidTransform ReadTransform(const YamlValue& value) {
  const std::vector<YamlValue> items = value.Items();
  if (items.size() != 16 && items.size() != 7) {
    if (value.IsSequence()) {
      value.Reject("16 numbers (4x4 matrix by rows) or 7 numbers [x, y, z, qw, qx, qy, qz]");
    }
    return {};
  }
  std::vector<double> v;
  for (const YamlValue& item : items) {
    v.push_back(item.Real(std::numeric_limits<double>::quiet_NaN(), kCoordinate));
    if (std::isnan(v.back())) return {};  // reported at the element
  }
  return items.size() == 16 ? FromMatrixRows(value, v) : FromPositionQuaternion(value, v);
}

StationPrior ReadPrior(const YamlValue& map) {
  StationPrior prior;
  prior.survey_from_station = ReadTransform(map.Required("survey_from_station"));
  prior.sigma_m = map.Required("sigma_m").Real(prior.sigma_m, kSigma);
  prior.sigma_deg = map.Required("sigma_deg").Real(prior.sigma_deg, kSigmaAngle);
  return prior;
}

std::string ReadScanPath(const YamlValue& value) {
  std::string path = value.Path();
  if (path.empty()) return path;
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    value.Reject("an existing scan file", "no such file: " + path);
  } else if (!std::filesystem::is_regular_file(status)) {
    value.Reject("an existing scan file", "not a file: " + path);
  }
  return path;
}

using ScanKey = std::pair<std::string, int>;

/// The same file by another name (links, "a/../b") is still the same file.
ScanKey KeyOfScan(const StationSpec& station) {
  std::error_code error;
  const auto canonical = std::filesystem::weakly_canonical(station.scan, error);
  return {error ? station.scan : canonical.string(), station.scan_index};
}

/// Columns of a text scan; whether `scan` is one is looked up if it can be opened.
TextColumns ReadColumns(const YamlValue& list, const std::string& scan) {
  constexpr std::size_t kMaxColumns = 256;
  TextColumns columns;
  for (const YamlValue& item : list.Items(3, kMaxColumns)) {
    const int choice = item.Choice(-1, TextColumnNames());
    if (choice < 0) return {};  // reported at the element
    columns.push_back(static_cast<TextColumn>(choice));
  }
  if (columns.empty()) return {};
  const std::string fault = FaultOf(columns);
  if (!fault.empty()) {
    list.Reject("x, y and z once each, intensity or not, r, g and b or none of them, and skip", "",
                fault);
  }
  try {
    if (!TakesColumns(scan)) {
      list.Reject("no columns: only text scans (XYZ, PTS) do not say what they hold");
    }
  } catch (const InputError&) {
    // A scan that cannot be read fails its station later, with the reason.
  }
  return columns;
}

StationSpec ReadStation(const YamlValue& item, std::map<std::string, int>& ids,
                        std::map<ScanKey, int>& scans) {
  StationSpec station;
  station.id = ReadId(item.Required("id"), ids);
  const YamlValue scan = item.Required("scan");
  station.scan = ReadScanPath(scan);
  const YamlValue index = item.Optional("scan_index");
  if (index.present()) station.scan_index = index.Integer(-1, 0, 1000000);
  if (!station.scan.empty() && station.scan_index >= 0) {
    const auto [it, inserted] = scans.emplace(KeyOfScan(station), scan.line());
    if (!inserted) {
      scan.Reject(
          "a scan of its own for each station",
          fmt::format("line {} has the same scan {} of this file", it->second, station.scan_index));
    }
  }
  station.levelled = item.Optional("levelled").Flag(false);
  const YamlValue level_sigma = item.Optional("level_sigma_deg");
  station.level_sigma_deg = level_sigma.Real(station.level_sigma_deg, {1e-6, 45.0, "deg"});
  if (level_sigma.present() && !station.levelled) {
    level_sigma.Reject("this key only together with levelled: true");
  }
  const YamlValue prior = item.Optional("prior");
  if (prior.present()) station.prior = ReadPrior(prior);
  const YamlValue origin = item.Optional("scanner_origin_m");
  if (origin.present()) station.scanner_origin_m = ReadVector(origin, kCoordinate);
  const YamlValue columns = item.Optional("columns");
  if (columns.present()) station.columns = ReadColumns(columns, station.scan);
  return station;
}

ControlPoint ReadControlPoint(const YamlValue& item, std::map<std::string, int>& ids,
                              const std::vector<StationSpec>& stations) {
  ControlPoint point;
  point.id = ReadId(item.Required("id"), ids);
  point.crs_m = ReadVector(item.Required("crs"), kCoordinate);
  point.sigma_m = ReadVector(item.Required("sigma_m"), kSigma);
  point.role =
      static_cast<ControlPoint::Role>(item.Required("role").Choice(0, {"control", "check"}));
  for (const YamlValue& measured : item.Required("measured").Items(1)) {
    ControlMeasurement measurement;
    const YamlValue station = measured.Required("station");
    measurement.station = station.Text();
    RequireStation(station, measurement.station, stations);
    measurement.xyz_m = ReadVector(measured.Required("xyz"), kCoordinate);
    point.measured.push_back(std::move(measurement));
  }
  return point;
}

}  // namespace

std::vector<StationSpec> ReadStations(const YamlValue& list) {
  std::vector<StationSpec> stations;
  std::map<std::string, int> ids;
  std::map<ScanKey, int> scans;
  const auto items = list.Items(0, kMaxStations);
  stations.reserve(items.size());
  for (const YamlValue& item : items) stations.push_back(ReadStation(item, ids, scans));
  if (list.IsSequence() && items.size() < 2) list.Reject("at least 2 stations");
  return stations;
}

std::vector<ControlPoint> ReadControl(const YamlValue& list,
                                      const std::vector<StationSpec>& stations) {
  std::vector<ControlPoint> points;
  std::map<std::string, int> ids;
  for (const YamlValue& item : list.Items()) {
    points.push_back(ReadControlPoint(item, ids, stations));
  }
  return points;
}

void RequireStation(const YamlValue& value, const std::string& id,
                    const std::vector<StationSpec>& stations) {
  if (id.empty() || stations.empty()) return;  // reported elsewhere
  std::vector<std::string> names;
  names.reserve(stations.size());
  for (const StationSpec& station : stations) {
    if (station.id.empty()) return;  // reported there, and may be the one meant here
    names.push_back(station.id);
  }
  if (std::find(names.begin(), names.end(), id) != names.end()) return;
  const std::string nearest = NearestName(id, names);
  value.Reject("the id of a station", nearest.empty() ? "" : "did you mean '" + nearest + "'?");
}

}  // namespace backsight
