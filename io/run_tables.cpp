#include "io/run_tables.h"

#include <Eigen/Geometry>
#include <array>
#include <optional>

#include "core/error.h"
#include "io/csv_table.h"

namespace backsight {
namespace {

const char* const kPoseNames[] = {"tx_m", "ty_m", "tz_m", "qw", "qx", "qy", "qz"};

/// Collects header and cells together, so that a column cannot lose its name.
class CsvBuilder {
 public:
  explicit CsvBuilder(std::string table) : table_(std::move(table)) {}

  void BeginRow(const std::string& what) {
    what_ = what;
    cells_.clear();
    header_.clear();
  }
  void Text(const std::string& column, const std::string& value) {
    header_.push_back(column);
    cells_.push_back(value);
  }
  void Real(const std::string& column, std::optional<double> value) {
    Text(column, value ? ExactText(*value, table_ + ", " + what_ + ", " + column) : std::string());
  }
  void Integer(const std::string& column, std::optional<int> value) {
    Text(column, value ? std::to_string(*value) : std::string());
  }
  void Boolean(const std::string& column, std::optional<bool> value) {
    Text(column, !value ? "" : *value ? "true" : "false");
  }
  void Transform(const std::string& prefix, const std::optional<RigidTransform>& transform) {
    std::vector<double> v;
    if (transform) {
      const Eigen::Vector3d& t = transform->translation;
      const Eigen::Quaterniond q = transform->Quaternion();
      v = {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()};
    }
    for (std::size_t i = 0; i < 7; ++i) {
      Real(prefix + kPoseNames[i], v.empty() ? std::nullopt : std::optional(v[i]));
    }
  }
  void EndRow() { body_ += CsvLine(cells_); }
  /// Call it after a BeginRow ... row of the same columns.
  std::string HeaderLine() const { return CsvLine(header_); }
  const std::string& body() const { return body_; }

 private:
  std::string table_;
  std::string what_;
  std::vector<std::string> header_;
  std::vector<std::string> cells_;
  std::string body_;
};

/// Empty cells where no control places the station.
void FillGround(CsvBuilder& csv, const std::optional<GroundPose>& ground) {
  csv.Transform("enu_", ground ? std::optional(ground->enu_from_station) : std::nullopt);
  const auto cells = [&](const std::array<const char*, 3>& columns, const Eigen::Vector3d& values) {
    for (std::size_t i = 0; i < 3; ++i) {
      csv.Real(columns[i],
               ground ? std::optional(values[static_cast<Eigen::Index>(i)]) : std::nullopt);
    }
  };
  const GroundPose pose = ground.value_or(GroundPose{});
  cells({"crs_easting", "crs_northing", "crs_height"}, pose.position);
  cells({"sigma_east_m", "sigma_north_m", "sigma_up_m"},
        SigmaOf(pose.enu_from_station, pose.covariance).position_m);
}

void FillPose(CsvBuilder& csv, const PoseRecord& pose) {
  const bool placed = pose.status == StationStatus::kRegistered;
  const std::optional<PoseSigma> sigma = placed ? SigmaOf(pose) : std::nullopt;
  const auto known = [&](double value) { return sigma ? std::optional(value) : std::nullopt; };
  const PoseSigma s = sigma.value_or(PoseSigma{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  csv.BeginRow("station " + pose.station);
  csv.Text("station", pose.station);
  csv.Integer("component", placed ? std::optional(pose.component) : std::nullopt);
  csv.Text("status", ToString(pose.status));
  csv.Transform("", placed ? std::optional(pose.survey_from_station) : std::nullopt);
  csv.Text("reason", pose.reason);
  csv.Integer("links", pose.link_count);
  csv.Real("sigma_x_m", known(s.position_m.x()));
  csv.Real("sigma_y_m", known(s.position_m.y()));
  csv.Real("sigma_z_m", known(s.position_m.z()));
  csv.Real("sigma_worst_m", known(s.worst_position_m));
  csv.Real("sigma_rx_deg", known(s.rotation_deg.x()));
  csv.Real("sigma_ry_deg", known(s.rotation_deg.y()));
  csv.Real("sigma_rz_deg", known(s.rotation_deg.z()));
  FillGround(csv, pose.ground);
}

/// What the adjusted network says of the link's own error.
void FillNetworkErrors(CsvBuilder& csv, const LinkRecord& link) {
  std::optional<double> sigma_m, sigma_deg;
  if (link.fine && link.covariance) {
    const PoseSigma sigma = SigmaOf(*link.fine, *link.covariance);
    sigma_m = sigma.worst_position_m;
    sigma_deg = sigma.rotation_deg.maxCoeff();
  }
  csv.Real("sigma_worst_m", sigma_m);
  csv.Real("sigma_worst_deg", sigma_deg);
  const auto held_out = [&](double HeldOutRecord::*figure) {
    return link.held_out ? std::optional(*link.held_out.*figure) : std::nullopt;
  };
  csv.Integer("held_out_planes",
              link.held_out ? std::optional(link.held_out->planes) : std::nullopt);
  csv.Real("held_out_rms_before_m", held_out(&HeldOutRecord::rms_before_m));
  csv.Real("held_out_rms_after_m", held_out(&HeldOutRecord::rms_after_m));
  csv.Real("held_out_bias_before_m", held_out(&HeldOutRecord::bias_before_m));
  csv.Real("held_out_bias_after_m", held_out(&HeldOutRecord::bias_after_m));
}

void FillLink(CsvBuilder& csv, const LinkRecord& link) {
  const auto tried = [&](auto value) {
    return link.status != LinkStatus::kSkipped ? std::optional(value) : std::nullopt;
  };
  const bool aligned = link.fine.has_value() || link.coarse.has_value();
  csv.BeginRow("link " + link.source + " " + link.target);
  csv.Text("source", link.source);
  csv.Text("target", link.target);
  csv.Text("status", ToString(link.status));
  csv.Text("reason", link.reason);
  csv.Transform("", link.fine);
  csv.Transform("coarse_", link.coarse);
  csv.Real("overlap", aligned ? std::optional(link.overlap) : std::nullopt);
  csv.Real("rms_m", link.rms_m);
  csv.Text("fine_status", link.fine_status);
  csv.Integer("correspondences", tried(link.correspondences));
  csv.Integer("consensus", tried(link.consensus));
  csv.Integer("consensus_null", tried(link.consensus_null));
  csv.Integer("planes", link.fine ? std::optional(link.planes) : std::nullopt);
  csv.Real("weakest_sigma_m", link.weakest_sigma_m);
  csv.Integer("iterations", link.fine ? std::optional(link.iterations) : std::nullopt);
  csv.Real("network_weight", link.network_weight);
  csv.Real("network_residual_m", link.network_residual_m);
  csv.Real("network_residual_deg", link.network_residual_deg);
  csv.Boolean("loop_controlled", link.loop_controlled);
  csv.Integer("candidates", aligned ? std::optional(link.candidates) : std::nullopt);
  csv.Real("conflict", aligned ? std::optional(link.conflict) : std::nullopt);
  csv.Real("agreement", aligned ? std::optional(link.agreement) : std::nullopt);
  FillNetworkErrors(csv, link);
  csv.Real("network_residual_sigmas", link.network_residual_sigmas);
  const auto worst_place = [&](double value) {
    return link.worst_place ? std::optional(value) : std::nullopt;
  };
  const WorstPlaceRecord place = link.worst_place.value_or(WorstPlaceRecord());
  csv.Real("worst_place_sigma_m", worst_place(place.sigma_m));
  csv.Real("worst_place_x", worst_place(place.direction.x()));
  csv.Real("worst_place_y", worst_place(place.direction.y()));
  csv.Real("worst_place_z", worst_place(place.direction.z()));
  csv.Boolean("predicted", tried(link.predicted));
}

template <typename Record>
std::string Table(const std::string& name, const std::vector<Record>& records,
                  void (*fill)(CsvBuilder&, const Record&)) {
  CsvBuilder csv(name);
  for (const Record& record : records) {
    fill(csv, record);
    csv.EndRow();
  }
  fill(csv, Record{});
  return csv.HeaderLine() + csv.body();
}

}  // namespace

std::string PosesCsv(const std::vector<PoseRecord>& poses) {
  return Table("poses.csv", poses, FillPose);
}

std::string LinksCsv(const std::vector<LinkRecord>& links) {
  return Table("links.csv", links, FillLink);
}

}  // namespace backsight
