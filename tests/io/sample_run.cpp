#include "tests/io/sample_run.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "core/random.h"
#include "io/html_text.h"
#include "io/png_image.h"

namespace backsight {
namespace {

PoseRecord SamplePose(int number, Random& random) {
  PoseRecord pose;
  pose.station = fmt::format("S{}", number);
  if (number >= 11) {
    pose.status = number == 11 ? StationStatus::kNotRegistered : StationStatus::kUnreadable;
    pose.reason = number == 11 ? "no_accepted_link" : "scans/S12.ptx:12: 'abc'; expected a number";
    return pose;
  }
  pose.status = StationStatus::kRegistered;
  pose.component = number >= 9 ? 1 : 0;
  pose.link_count = 2;
  pose.survey_from_station = {
      random.Rotation(),
      {18.0 * std::cos(0.8 * number) + random.Uniform(-3, 3),
       11.0 * std::sin(0.8 * number) + random.Uniform(-3, 3), random.Uniform(-0.5, 0.5)}};
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << 1e-9, 1e-9, 4e-9, 1e-6, 2e-6, 4e-6;
  pose.covariance = covariance * (0.5 + random.Uniform());
  return pose;
}

LinkRecord SampleLink(const RunRecord& run, int source, int target, LinkStatus status,
                      Random& random) {
  LinkRecord link;
  link.source = fmt::format("S{}", source);
  link.target = fmt::format("S{}", target);
  link.status = status;
  link.correspondences = 400 + static_cast<int>(random.Index(400));
  if (status == LinkStatus::kFailed) {
    link.reason = "too_few_keypoints";
    return link;
  }
  const auto& poses = run.poses;
  link.coarse = poses[static_cast<std::size_t>(target - 1)].survey_from_station.Inverse() *
                poses[static_cast<std::size_t>(source - 1)].survey_from_station;
  link.consensus = 60 + static_cast<int>(random.Index(90));
  link.consensus_null = 9;
  link.overlap = random.Uniform(0.15, 0.7);
  if (status == LinkStatus::kRejected) {
    link.reason = "free_space_conflict";
    link.agreement = -0.46;
    return link;
  }
  link.fine = link.coarse;
  link.fine_status = "refined";
  link.planes = 800;
  link.rms_m = random.Uniform(0.001, 0.004);
  link.weakest_sigma_m = random.Uniform(0.0003, 0.002);
  link.iterations = 14;
  link.network_weight = random.Uniform(0.7, 1.0);
  link.network_residual_m = random.Uniform(0.0, 0.024);
  link.network_residual_deg = random.Uniform(0.0, 0.02);
  link.network_residual_sigmas = random.Uniform(0.0, 2.5);
  link.loop_controlled = source < 9;
  link.candidates = 2;
  link.predicted = source % 3 == 0;
  link.conflict = random.Uniform(0.0, 0.08);
  link.agreement = random.Uniform(0.4, 0.8);
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << 1e-9, 1e-9, 2e-9, 1e-6, 1e-6, 2e-6;
  link.covariance = covariance;
  link.held_out = HeldOutRecord{31, 0.0034, 0.0021, -0.0009, 0.0002};
  link.worst_place = WorstPlaceRecord{random.Rotation().col(0), random.Uniform(0.0003, 0.002)};
  return link;
}

/// Turned by a quarter against the survey frame, and near the control.
GroundPose SampleGround(const PoseRecord& pose) {
  RigidTransform enu_from_survey;
  enu_from_survey.rotation << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  enu_from_survey.translation = {20.0, 20.0, 0.5};
  GroundPose ground;
  ground.enu_from_station = enu_from_survey * pose.survey_from_station;
  ground.covariance = *pose.covariance;
  ground.position =
      ground.enu_from_station.translation + Eigen::Vector3d(691000.0, 5335800.0, 512.0);
  return ground;
}

/// One control point, one that was excluded, one check point.
GeoreferenceRecord SampleGeoreference() {
  GeoreferenceRecord record;
  record.status = "georeferenced";
  record.crs = "ETRS89 / UTM zone 32N";
  record.heights = "ellipsoidal heights";
  record.origin_deg_deg_m = Eigen::Vector3d(48.15, 11.55, 560.0);
  record.origin_crs_m = Eigen::Vector3d(691000.0, 5335800.0, 512.0);
  record.scale_test = ScaleRecord{12.5, 30.5};
  SurveyPointRecord control;
  control.id = "P1";
  control.position = {691020.0, 5335820.0, 512.0};
  control.sightings = 2;
  control.residual_m = {0.001, -0.002, 0.0005};
  control.free_residual_m = Eigen::Vector3d(0.0015, -0.0025, 0.0005);
  control.w = Eigen::Vector3d(0.5, -1.1, 0.2);
  SurveyPointRecord blunder = control;
  blunder.id = "P2";
  blunder.position = {691041.5, 5335814.0, 512.4};
  blunder.excluded = true;
  SurveyPointRecord check = control;
  check.id = "C1";
  check.position = {691030.0, 5335829.5, 513.1};
  check.check = true;
  check.free_residual_m.reset();
  check.w.reset();
  check.sigma_m = Eigen::Vector3d(0.002, 0.002, 0.003);
  record.points = {control, blunder, check};
  record.check = {1, {0.001, 0.002, 0.0005}, 0.00224, 0.00229, 0.0041};
  return record;
}

DistanceRecord SampleDistances() {
  DistanceRecord record;
  record.search_m = 0.2;
  record.total = {8700, 0.0011, 0.0017, 0.0042};
  record.bin_m = 0.0002;
  for (std::uint64_t i = 0; i < 40; ++i) record.bins.push_back(420 - 10 * i);
  record.beyond = 100;
  record.pairs = {{{"S1", "S2"}, {4000, 0.0010, 0.0016, 0.0040}},
                  {{"S2", "S3"}, {4700, 0.0012, 0.0018, 0.0044}}};
  return record;
}

PictureRecord SamplePicture(PictureRecord::Kind kind) {
  RgbImage image(320, 90, {255, 255, 255});
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      image.Set(x, y, {static_cast<std::uint8_t>(x % 256), static_cast<std::uint8_t>(y), 7});
    }
  }
  PictureRecord picture;
  picture.kind = kind;
  picture.title = "Picture: " + ToString(kind);
  picture.caption = "A gradient.";
  picture.width_px = image.width;
  picture.height_px = image.height;
  picture.metres_per_pixel = 0.05;
  picture.left_top = {-4.0, 3.0};
  picture.across = "E";
  picture.up = "N";
  picture.keys = {{"S1", {0, 114, 178}}, {"S2", {213, 94, 0}}};
  picture.scale = PictureScale{"height [m]",
                               {{0.0, {68, 1, 84}}, {1.5, {33, 144, 141}}, {3.0, {253, 231, 37}}}};
  picture.lines = {{"A", {-3.0, 0.0}, {8.0, 1.0}}};
  picture.png_base64 = Base64(EncodePng(image));
  return picture;
}

}  // namespace

ReportDocument SampleReport(RunRecord run) {
  std::vector<PictureRecord> pictures;
  for (const PictureRecord::Kind kind : kPictureKinds) pictures.push_back(SamplePicture(kind));
  return MakeReportDocument(std::move(run), std::move(pictures));
}

ReportDocument SampleReport() { return SampleReport(SampleRun()); }

RunRecord LargeRun(int stations) {
  Random random(11);
  RunRecord run = SampleRun();
  run.verdict = fmt::format("Complete: all {} stations placed in one network.", stations);
  run.exit_code = 0;
  run.poses.clear();
  run.links.clear();
  run.scans.clear();
  run.components.resize(1);
  run.georeference.clear();
  run.survey_points = 0;
  const ScanRecord scan = SampleRun().scans.front();
  for (int i = 1; i <= stations; ++i) {
    PoseRecord pose = SamplePose(1, random);
    pose.station = fmt::format("S{:03d}", i);
    const double along = 14.0 * i;
    pose.survey_from_station.translation = {
        std::fmod(along, 280.0) + random.Uniform(-4, 4),
        22.0 * std::floor(along / 280.0) + random.Uniform(-5, 5), 0.01 * i};
    run.poses.push_back(pose);
    run.scans.push_back(scan);
    run.scans.back().station = pose.station;
  }
  for (int i = 0; i < stations; ++i) {
    for (const int step : {1, 2, 20, 21, 5}) {
      if (i + step >= stations) continue;
      LinkRecord link = SampleLink(
          SampleRun(), 1, 2, step == 5 ? LinkStatus::kRejected : LinkStatus::kAccepted, random);
      link.source = run.poses[static_cast<std::size_t>(i)].station;
      link.target = run.poses[static_cast<std::size_t>(i + step)].station;
      run.links.push_back(link);
    }
  }
  return run;
}

RunRecord SampleRun() {
  Random random(7);
  RunRecord run;
  run.project_name = "Town hall facade";
  run.version = "0.1.0";
  run.verdict = "Partial: 10 of 12 stations are registered, in 2 components; 1 gate failed.";
  run.exit_code = 3;
  for (int i = 1; i <= 12; ++i) run.poses.push_back(SamplePose(i, random));
  for (int i = 1; i <= 7; ++i) {
    run.links.push_back(SampleLink(run, i, i + 1, LinkStatus::kAccepted, random));
  }
  run.links.push_back(SampleLink(run, 1, 8, LinkStatus::kAccepted, random));
  run.links.push_back(SampleLink(run, 2, 7, LinkStatus::kRejected, random));
  run.links.push_back(SampleLink(run, 3, 6, LinkStatus::kRejected, random));
  run.links.push_back(SampleLink(run, 9, 10, LinkStatus::kAccepted, random));
  run.links.push_back(SampleLink(run, 1, 11, LinkStatus::kFailed, random));
  for (int i = 1; i <= 11; ++i) {
    ScanRecord scan;
    scan.station = fmt::format("S{}", i);
    scan.path = fmt::format("scans/S{}.ptx", i);
    scan.format = "PTX";
    scan.records = 12000000;
    scan.dropped = 250000;
    scan.points = scan.records - scan.dropped;
    scan.leaves = 182000;
    scan.keypoints = 3100;
    scan.extent_m = 41.25;
    if (i == 3) scan.notes = {"repaired: 12 records with a decimal comma", "no intensity"};
    run.scans.push_back(scan);
  }
  run.outputs = {{"out/merged.las", "las", "the best per cell of 5 mm", 45123456},
                 {"out/stations/S1.e57", "E57", "", 11750000},
                 {"out/map.ot", "OctoMap", "", std::nullopt}};
  run.gates = {{"require_all_stations", "12", "10", false},
               {"max_station_sigma_mm", "5 mm", "2.9 mm", true}};
  run.warnings = {"The link S9 S10 lies on no loop: nothing controls it."};
  run.components = {{.component = 0,
                     .stations = 8,
                     .links = 8,
                     .redundancy = 6,
                     .sigma_factor = 1.3,
                     .refinement = "refined",
                     .planes = 2310,
                     .observations = 6120,
                     .rounds = 3,
                     .iterations = 11,
                     .plane_sigma_factor = 1.8,
                     .weakest_station = "S5",
                     .weakest_sigma_m = 0.0026},
                    {.component = 1, .stations = 2, .links = 1, .refinement = "too_few_planes"}};
  run.closures = {{{"S1", "S2", "S8"}, 0.021, 0.051, 0.0017, 0.004}};
  run.georeference = {SampleGeoreference()};
  run.survey_points = 3;
  for (PoseRecord& pose : run.poses) {
    if (pose.component == 0) pose.ground = SampleGround(pose);
  }
  run.distances = SampleDistances();
  run.network = {{"sigma_factor", 1.3},
                 {"cycle_sigma_factor", 1.1},
                 {"redundancy", 12.0},
                 {"robust_rounds", 9.0},
                 {"links_removed", 2.0},
                 {"links_readmitted", 0.0},
                 {"pairs_registered_in_full", 12.0},
                 {"pairs_from_predicted_poses", 0.0},
                 {"station_pairs_compared_in_place", 28.0},
                 {"station_pairs_in_conflict", 1.0}};
  return run;
}

TestFolder::TestFolder()
    : folder_(std::filesystem::path(::testing::TempDir()) /
              fmt::format("backsight_{}_{}", getpid(),
                          ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
  std::filesystem::create_directories(folder_);
}

TestFolder::~TestFolder() {
  std::error_code error;
  std::filesystem::remove_all(folder_, error);
}

std::string TestFolder::Write(const std::string& name, const std::string& text) const {
  std::filesystem::create_directories((folder_ / name).parent_path());
  std::ofstream(folder_ / name, std::ios::binary) << text;
  return Path(name);
}

}  // namespace backsight
