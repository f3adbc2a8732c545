#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/rigid_transform.h"
#include "io/distance_records.h"

namespace backsight {

/// Components count from 0 in the program and in what machines read: the columns and keys
/// `component` of poses.csv and the JSON files. What people read counts from 1: this number, in
/// report.html, in warnings and in file names (merged_component2.las is component 1 of poses.csv).
constexpr int ComponentNumber(int component) { return component + 1; }

/// The words of the `status` columns. Doubtful: not refuted, but used only if loops of other links
/// confirm it, and none does.
enum class StationStatus { kRegistered, kNotRegistered, kUnreadable };
enum class LinkStatus { kAccepted, kDoubtful, kRejected, kFailed, kSkipped };

inline constexpr StationStatus kStationStatuses[] = {
    StationStatus::kRegistered, StationStatus::kNotRegistered, StationStatus::kUnreadable};
inline constexpr LinkStatus kLinkStatuses[] = {LinkStatus::kAccepted, LinkStatus::kDoubtful,
                                               LinkStatus::kRejected, LinkStatus::kFailed,
                                               LinkStatus::kSkipped};

std::string ToString(StationStatus status);
std::string ToString(LinkStatus status);

/// A station in the frame of the control.
struct GroundPose {
  RigidTransform enu_from_station;
  Matrix6d covariance = Matrix6d::Zero();              ///< Retract's convention; rad, m
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< in the CRS, or the control's local grid
};

/// One line of poses.csv.
struct PoseRecord {
  std::string station;
  int component = -1;  ///< from 0, ComponentNumber; -1: not placed
  StationStatus status = StationStatus::kNotRegistered;
  std::string reason;  ///< empty where registered
  RigidTransform survey_from_station;
  std::optional<Matrix6d> covariance;     ///< [rotation; translation], Retract's convention; rad, m
  int link_count = 0;                     ///< accepted links of this station
  std::optional<GroundPose> ground = {};  ///< where control places its component
};

/// Formal standard deviations of a placed station. The covariance is that of a perturbation of the
/// whole survey_from_station (Retract); here it is carried to the station's own position,
/// t + phi x t + rho, because that is what a surveyor asks for.
struct PoseSigma {
  Eigen::Vector3d rotation_deg;   ///< about the axes of the survey frame
  Eigen::Vector3d position_m;     ///< along the axes of the survey frame
  double worst_position_m = 0.0;  ///< in the least determined direction
};

/// Absent where the record holds no covariance.
std::optional<PoseSigma> SigmaOf(const PoseRecord& pose);

/// The same of any motion with a covariance in Retract's convention.
PoseSigma SigmaOf(const RigidTransform& motion, const Matrix6d& covariance);

/// Horizontal standard error ellipse of a position.
struct ErrorEllipse {
  double semi_major_m = 0.0;
  double semi_minor_m = 0.0;
  double azimuth_deg = 0.0;  ///< of the major axis, from y towards x, 0 to 180
};
ErrorEllipse EllipseOf(const RigidTransform& motion, const Matrix6d& covariance);

/// How two stations' views of the planes differ that took no part in the network's adjustment:
/// an independent check. Metres, distances of one station's points from the other's plane.
struct HeldOutRecord {
  int planes = 0;
  double rms_before_m = 0.0;  ///< before the planes of all stations were adjusted together
  double rms_after_m = 0.0;
  double bias_before_m = 0.0;  ///< mean signed distance
  double bias_after_m = 0.0;
};

/// Where a pair's registration determines the place of the source's scanner least.
struct WorstPlaceRecord {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< unit, in the target's station frame
  double sigma_m = 0.0;                                  ///< formal, of the pair alone
};

/// One line of links.csv: what became of one pair. Transforms are target_from_source.
struct LinkRecord {
  std::string source;
  std::string target;
  LinkStatus status = LinkStatus::kFailed;
  std::string reason;  ///< reason code; empty where accepted
  std::optional<RigidTransform> coarse;
  std::optional<RigidTransform> fine;
  std::string fine_status;  ///< how the fine registration ended
  int correspondences = 0;  ///< |C1|
  int consensus = 0;        ///< distinct inlier keypoints of the coarse transform
  int consensus_null = 0;   ///< best consensus of the permuted correspondences
  int candidates = 0;       ///< motions that were compared, the reported one among them
  /// The network, or a symmetry that other pairs have shown, predicted the reported motion: no key
  /// points proposed it, so that it has no consensus.
  bool predicted = false;
  double overlap = 0.0;    ///< 0 to 1, the smaller of both directions
  double conflict = 0.0;   ///< share of surfaces in view that a scanner saw through, worse side
  double agreement = 0.0;  ///< score of the clouds under this motion; decides between candidates
  int planes = 0;
  /// Of points from the pair's adjusted planes, weighted as in that adjustment; absent without.
  std::optional<double> rms_m;
  /// Formal, of the motion that the pair determines least, turns counted by the shift that they
  /// cause at the pair's planes.
  std::optional<double> weakest_sigma_m;
  int iterations = 0;                    ///< Levenberg-Marquardt iterations, all rounds
  std::optional<double> network_weight;  ///< 0 (removed by the pose graph) or 1; absent: not in it
  /// Place of the source and rotation, by the link and by the adjusted network: how far apart.
  /// Absent where both stations do not stand in one component.
  std::optional<double> network_residual_m;
  std::optional<double> network_residual_deg;
  /// The same in the pair's own standard deviations as the network takes them (held above the
  /// systematic floor, times the links' sigma factor), rms over the six unknowns.
  std::optional<double> network_residual_sigmas;
  std::optional<bool> loop_controlled;  ///< lies on a loop of accepted links; absent: not known
  /// Of target_from_source in the adjusted network, Retract's convention; rad, m.
  std::optional<Matrix6d> covariance;
  std::optional<HeldOutRecord> held_out;
  std::optional<WorstPlaceRecord>
      worst_place;  ///< where the fine registration determines the motion
};

/// Three stations joined by accepted links, and by how much the three motions miss the identity.
struct ClosureRecord {
  std::array<std::string, 3> stations;
  double coarse_m = 0.0;  ///< of the coarse motions
  double coarse_deg = 0.0;
  double fine_m = 0.0;  ///< of the refined motions
  double fine_deg = 0.0;
};

/// How the adjustment of one component of the network ended.
struct ComponentRecord {
  int component = 0;
  int stations = 0;
  int links = 0;
  int redundancy = 0;
  double sigma_factor = 1.0;    ///< by how much the links disagree beyond their formal errors
  std::string refinement = {};  ///< how the planar adjustment over all stations ended
  int planes = 0;
  int observations = 0;
  int rounds = 0;      ///< associations of planes
  int iterations = 0;  ///< Levenberg-Marquardt, all rounds
  int anderson_accepted = 0;
  /// By how much stations disagree on planes beyond noise; absent where none were adjusted.
  std::optional<double> plane_sigma_factor = {};
  std::string weakest_station = {};  ///< what the least determined direction moves most
  std::optional<double> weakest_sigma_m = {};
};

/// What the stations see of a survey point less its given coordinates; metres, along east, north
/// and up of the given coordinates (grid axes).
struct SurveyPointRecord {
  std::string id;
  bool check = false;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< as given: in the CRS or the local grid
  bool excluded = false;                               ///< a blunder: it takes no part
  int sightings = 0;
  Eigen::Vector3d residual_m = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> free_residual_m;    ///< control: of the network moved as a whole
  std::optional<Eigen::Vector3d> w;                  ///< control: Baarda's standardised residuals
  std::array<bool, 3> checked = {true, true, true};  ///< control: whether anything else checks it
  std::optional<Eigen::Vector3d> sigma_m;            ///< check: predicted of the residual
};

/// Root mean square errors over the check points of a component (ASPRS positional accuracy,
/// edition 2, 2023), metres.
struct CheckRecord {
  int points = 0;
  Eigen::Vector3d rmse_m = Eigen::Vector3d::Zero();
  double rmse_horizontal_m = 0.0;
  double rmse_3d_m = 0.0;
  double predicted_3d_m = 0.0;  ///< from the covariances
};

/// What control says of a component's scale.
struct ScaleRecord {
  double off_ppm = 0.0;
  double sigma_ppm = 0.0;
};

/// How one component was tied to its control.
struct GeoreferenceRecord {
  int component = 0;
  std::string status;  ///< georeferenced, too_few_points, contradictory or diverged
  std::string crs;     ///< names and heights; "local grid" without a CRS
  std::string heights;
  std::optional<Eigen::Vector3d> origin_deg_deg_m;  ///< latitude, longitude, ellipsoidal height
  std::optional<Eigen::Vector3d> origin_crs_m;      ///< the same place in the CRS
  double convergence_deg = 0.0;
  double point_scale = 1.0;               ///< of the grid at the origin
  RigidTransform enu_from_survey;         ///< meaningful where placed(), as what follows
  double scale = 1.0;                     ///< applied
  std::optional<ScaleRecord> scale_test;  ///< absent: its adjustment did not converge
  int redundancy = 0;
  double variance_factor = 1.0;  ///< applied to the covariances
  std::vector<SurveyPointRecord> points;
  CheckRecord check;

  /// Whether control places the component, be it with contradictions.
  bool placed() const { return status == "georeferenced" || status == "contradictory"; }
};

/// One scan as it was read.
struct ScanRecord {
  std::string station;
  std::string path;
  std::string format;
  std::uint64_t records = 0;
  std::uint64_t points = 0;
  std::uint64_t dropped = 0;
  std::uint64_t moving = 0;  ///< points of things that were gone when other stations looked
  std::size_t leaves = 0;
  std::size_t keypoints = 0;
  double extent_m = 0.0;           ///< 95th percentile of range
  std::vector<std::string> notes;  ///< repairs, guesses, warnings
};

struct OutputRecord {
  std::string path;
  std::string format;
  std::string selection;                ///< of the stations' points; empty: all, or no cloud
  std::optional<std::uint64_t> points;  ///< of clouds
};

/// A quality gate of the project file and how it ended.
struct GateRecord {
  std::string name;
  std::string limit;
  std::string value;
  bool passed = false;
};

/// Everything poses, links and reports are written from. No wall-clock times: those live in the
/// manifest, so that equal runs give equal reports.
struct RunRecord {
  std::string project_name;
  std::string version;
  std::string verdict;  ///< one sentence for people
  int exit_code = 0;
  std::vector<ScanRecord> scans;
  std::vector<PoseRecord> poses;
  std::vector<LinkRecord> links;
  std::vector<OutputRecord> outputs;
  std::vector<GateRecord> gates;
  std::vector<std::string> warnings;
  std::vector<ComponentRecord> components;
  std::vector<ClosureRecord> closures;
  int survey_points = 0;                         ///< control and check points of the project file
  std::vector<GeoreferenceRecord> georeference;  ///< by component; empty without control or network
  std::vector<std::pair<std::string, double>> network;  ///< named figures of the whole network
  std::optional<DistanceRecord> distances;              ///< absent: nothing overlaps
};

/// What a run needed; only manifest.json holds it.
struct StageTime {
  std::string stage;
  double seconds = 0.0;
  double processor_s = 0.0;  ///< over all threads
  double idle_share = 0.0;   ///< of the threads' time, 0 to 1: without work, or waiting for data
};

/// A cloud that a run wrote.
struct WrittenCloud {
  std::string path;  ///< absolute
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;  ///< time of the last change, nanoseconds since 1970 (UTC)
};

struct ManifestRecord {
  std::string version;
  std::string git_hash;
  std::string project_path;
  std::string options;  ///< canonical text of the effective options
  std::vector<std::pair<std::string, std::string>> inputs;  ///< path, fingerprint
  std::string started_utc;                                  ///< ISO 8601
  double wall_s = 0.0;
  double peak_memory_mb = 0.0;
  int threads = 0;
  std::vector<StageTime> stages;
  std::vector<WrittenCloud> clouds;
};

}  // namespace backsight
