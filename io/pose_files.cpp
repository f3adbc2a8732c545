#include "io/pose_files.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <set>

#include "core/error.h"
#include "io/csv_table.h"
#include "io/text_file.h"

namespace backsight {
namespace {

// Published ground truth is written with few digits.
constexpr double kRotationTolerance = 1e-2;

StationStatus ParseStatus(const CsvTable& table, const CsvTable::Row& row) {
  const std::string text = table.Text(row, "status");
  if (text.empty() || text == "ok") return StationStatus::kRegistered;
  for (const StationStatus status :
       {StationStatus::kRegistered, StationStatus::kNotRegistered, StationStatus::kUnreadable}) {
    if (text == ToString(status)) return status;
  }
  throw InputError({table.Where(row), "'" + text + "' in column status",
                    "registered, ok, not_registered or unreadable", ""});
}

RigidTransform ParseTransform(const CsvTable& table, const CsvTable::Row& row) {
  const Eigen::Quaterniond q(table.Real(row, "qw"), table.Real(row, "qx"), table.Real(row, "qy"),
                             table.Real(row, "qz"));
  if (!(std::abs(q.norm() - 1.0) < kRotationTolerance)) {
    throw InputError({table.Where(row), fmt::format("a quaternion of length {:.6g}", q.norm()),
                      "a unit quaternion", ""});
  }
  return RigidTransform::FromQuaternion(
      q, {table.Real(row, "tx_m"), table.Real(row, "ty_m"), table.Real(row, "tz_m")});
}

/// Numbers separated by white space, each with the line it stands on.
class NumberFile {
 public:
  explicit NumberFile(const std::string& path) : path_(path), text_(ReadTextFile(path)) { Skip(); }

  bool AtEnd() const { return at_ >= text_.size(); }
  std::string Where() const { return fmt::format("{}:{}", path_, line_); }

  double Real() {
    double value = 0.0;
    const std::string token = Token();
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
    if (error != std::errc() || end != token.data() + token.size() || !std::isfinite(value)) {
      throw InputError({Where(), "'" + token.substr(0, 40) + "'", "a number", ""});
    }
    at_ += token.size();
    Skip();
    return value;
  }

  int Index() {
    const std::string where = Where();
    const double value = Real();
    if (value < 0.0 || value > 1e9 || value != std::floor(value)) {
      throw InputError({where, fmt::format("{}", value), "the number of a cloud", ""});
    }
    return static_cast<int>(value);
  }

  RigidTransform Matrix() {
    const std::string where = Where();
    Eigen::Matrix4d matrix;
    for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = Real();
    const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
    const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
    const bool affine = matrix.row(3) == Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0);
    if (!(error < kRotationTolerance) || rotation.determinant() < 0.0 || !affine) {
      throw InputError({where, "a matrix that is not rigid", "a rigid 4x4 matrix by rows", ""});
    }
    return RigidTransform::FromMatrix(matrix);
  }

 private:
  static constexpr const char* kSpace = " \t\r\n";

  std::string Token() const {
    return text_.substr(at_, std::min(text_.find_first_of(kSpace, at_), text_.size()) - at_);
  }
  void Skip() {
    const std::size_t next = std::min(text_.find_first_not_of(kSpace, at_), text_.size());
    for (; at_ < next; ++at_) line_ += text_[at_] == '\n' ? 1 : 0;
  }

  std::string path_;
  std::string text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

std::map<std::string, RigidTransform> ReadTruthFolder(const std::string& path) {
  std::map<std::string, RigidTransform> poses;
  constexpr std::string_view kPrefix = "gt_pose";
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    const std::string stem = entry.path().stem().string();
    if (!stem.starts_with(kPrefix) || entry.path().extension() != ".txt") continue;
    const std::string number = stem.substr(kPrefix.size());
    if (number.empty() || number.find_first_not_of("0123456789") != std::string::npos) continue;
    NumberFile file(entry.path().string());
    poses["s" + number] = file.Matrix();
    if (!file.AtEnd()) throw InputError({file.Where(), "more than 16 numbers", "16", ""});
  }
  return poses;
}

}  // namespace

std::vector<PoseRecord> ReadPoseRecords(const std::string& path) {
  const CsvTable table = CsvTable::Load(path);
  for (const char* column : {"station", "tx_m", "ty_m", "tz_m", "qw", "qx", "qy", "qz"}) {
    if (!table.HasColumn(column)) {
      throw InputError(
          {path + ":1", fmt::format("no column '{}'", column), "the columns of poses.csv", ""});
    }
  }
  std::vector<PoseRecord> records;
  std::set<std::string> stations;
  for (const CsvTable::Row& row : table.rows()) {
    PoseRecord record;
    record.station = table.Text(row, "station");
    if (record.station.empty() || !stations.insert(record.station).second) {
      throw InputError(
          {table.Where(row), "station '" + record.station + "'", "each station once, by name", ""});
    }
    record.status = ParseStatus(table, row);
    record.reason = table.Text(row, "reason");
    if (!table.Text(row, "links").empty()) record.link_count = table.Integer(row, "links");
    if (record.status == StationStatus::kRegistered) {
      record.survey_from_station = ParseTransform(table, row);
      record.component = table.Text(row, "component").empty() ? 0 : table.Integer(row, "component");
    }
    records.push_back(std::move(record));
  }
  return records;
}

std::map<std::string, RigidTransform> ReadPoses(const std::string& path) {
  std::map<std::string, RigidTransform> poses;
  if (std::filesystem::is_directory(path)) {
    const std::string of_campaign = (std::filesystem::path(path) / "truth.csv").string();
    if (std::filesystem::exists(of_campaign)) return ReadPoses(of_campaign);
    poses = ReadTruthFolder(path);
    if (poses.empty()) {
      throw InputError({path, "no pose", "truth.csv or files gt_pose<number>.txt", ""});
    }
    return poses;
  }
  for (const PoseRecord& record : ReadPoseRecords(path)) {
    if (record.status == StationStatus::kRegistered) {
      poses[record.station] = record.survey_from_station;
    }
  }
  if (poses.empty()) throw InputError({path, "no pose", "at least one placed station", ""});
  return poses;
}

std::map<std::pair<std::string, std::string>, RigidTransform> ReadRelativeLog(
    const std::string& path) {
  std::map<std::pair<std::string, std::string>, RigidTransform> log;
  NumberFile file(path);
  while (!file.AtEnd()) {
    const std::string where = file.Where();
    const std::string target = fmt::format("cloud_bin_{}", file.Index());
    const std::string source = fmt::format("cloud_bin_{}", file.Index());
    file.Index();  // the number of clouds, the same in every block
    if (!log.emplace(std::pair(source, target), file.Matrix()).second) {
      throw InputError({where, source + " to " + target + " a second time", "each pair once", ""});
    }
  }
  if (log.empty()) throw InputError({path, "no transform", "blocks of a 3DMatch gt.log", ""});
  return log;
}

}  // namespace backsight
