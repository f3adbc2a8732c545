#include "pipeline/cloud_outputs.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <set>

#include "core/voxel_grid.h"
#include "io/e57/e57_writer.h"
#include "pipeline/e57_scans.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int kRows = 40;
constexpr int kColumns = 50;

PointChunk RandomScan(Random& random) {
  PointChunk chunk;
  for (std::int32_t i = 0; i < kRows * kColumns; ++i) {
    chunk.x.push_back(random.Uniform(1.0, 30.0));
    chunk.y.push_back(random.Uniform(-30.0, 30.0));
    chunk.z.push_back(random.Uniform(-2.0, 9.0));
    chunk.intensity.push_back(static_cast<float>(random.Uniform()));
    const auto level = [&random] { return static_cast<std::uint16_t>(random.Index(65536)); };
    chunk.rgb.push_back({level(), level(), level()});
    chunk.row.push_back(i % kRows);
    chunk.column.push_back(i / kRows);
  }
  return chunk;
}

/// Stations A, B and C, of which C has no place. A's scan has GUID and name, B's has none.
class CloudOutputsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    Random random(5);
    for (const std::string id : {"A", "B", "C"}) {
      points_.push_back(RandomScan(random));
      Station& station = stations_.emplace_back();
      station.spec.id = id;
      station.spec.scan = dir_ / (id + ".e57");
      WriteScan(station.spec.scan, id == "A" ? "{A-GUID}" : "", id == "A" ? "Hall" : "");
      station.info = OpenScan(station.spec.scan)->info();
      station.content_fingerprint = "points of " + id;
      station.model.min.setConstant(-50.0);
      station.model.max.setConstant(50.0);
      network_.survey_from_station.push_back(
          {random.Rotation(), Eigen::Vector3d(random.Normal(), random.Normal(), 12.3456789)});
    }
    network_.component = {0, 0, -1};
    ground_.enu_from_station.resize(3);
  }

  void WriteScan(const std::string& path, const std::string& guid, const std::string& name) {
    E57Writer writer({path, "{FILE}", "test", "", {}});
    E57ScanSpec scan;
    scan.guid = guid;
    scan.name = name;
    scan.has_intensity = true;
    scan.has_rgb = true;
    scan.rgb_16_bit = true;
    scan.rows = kRows;
    scan.columns = kColumns;
    writer.BeginScan(scan);
    writer.Write(points_.back());
    writer.EndScan();
    writer.Finish();
  }

  void TieToUtm() {
    auto frame = std::make_shared<GeodeticFrame>("EPSG:25832", "", "survey.yaml:3");
    frame->SetOrigin({690000.0, 5336000.0, 520.0});
    ground_.frame = frame;
    GeoreferencedPart& part = ground_.parts.emplace_back();
    part.result.status = GeoreferencingResult::Status::kGeoreferenced;
    for (const std::size_t s : {0U, 1U}) {
      const RigidTransform& pose = network_.survey_from_station[s];
      ground_.enu_from_station[s] = RigidTransform{pose.rotation, pose.translation.array() + 3.0};
    }
  }

  OutputFiles Write(std::vector<CloudOutput> merged, std::optional<CloudFormat> each) {
    SurveyProject project;
    project.outputs.merged = std::move(merged);
    if (each) {
      project.outputs.stations.emplace();
      project.outputs.stations->format = *each;
      project.outputs.stations->path = dir_ / "out/each/";
    }
    return WriteClouds(project, {ingest_, stations_, network_, ground_, moving_, store_, {}},
                       dir_ / "out", ExecutionContext{});
  }

  CloudOutput Merged(CloudFormat format, const std::string& name) const {
    CloudOutput output;
    output.format = format;
    output.path = dir_ / name;
    return output;
  }

  TempDir dir_;
  std::vector<PointChunk> points_;
  IngestOptions ingest_;
  std::vector<Station> stations_;
  Network network_;
  GeoreferencedNetwork ground_;
  MovingPoints moving_;
  ArtifactStore store_;
};

void ExpectSamePoints(const PointChunk& read, const PointChunk& scanned) {
  EXPECT_EQ(read.x, scanned.x);
  EXPECT_EQ(read.y, scanned.y);
  EXPECT_EQ(read.z, scanned.z);
  EXPECT_EQ(read.intensity, scanned.intensity);
  EXPECT_EQ(read.rgb, scanned.rgb);
  EXPECT_EQ(read.row, scanned.row);
  EXPECT_EQ(read.column, scanned.column);
}

void ExpectSamePose(const ScanInfo& info, const RigidTransform& pose) {
  ASSERT_TRUE(info.world_from_scan);
  EXPECT_EQ(info.world_from_scan->translation, pose.translation);
  EXPECT_LT((info.world_from_scan->rotation - pose.rotation).norm(), 1e-12);
}

TEST_F(CloudOutputsTest, StationE57HasItsScanAndThePose) {
  const OutputFiles written = Write({}, CloudFormat::kE57);
  ASSERT_EQ(written.files.size(), 2U);
  EXPECT_EQ(written.files[1].path, dir_ / "out/each/B.e57");
  EXPECT_EQ(written.files[1].format, "E57");
  EXPECT_EQ(written.files[1].points, points_[1].size());
  EXPECT_THAT(written.warnings, ElementsAre("no registered cloud of C: not placed in the network"));
  for (const std::size_t s : {0U, 1U}) {
    const auto scan = ReadWhole(written.files[s].path);
    ExpectSamePoints(scan.points, points_[s]);
    ExpectSamePose(scan.info, network_.survey_from_station[s]);
    EXPECT_EQ(scan.info.crs, "");
  }
  const ScanInfo a = OpenScan(written.files[0].path)->info();
  EXPECT_EQ(a.guid, "{A-GUID}");
  EXPECT_EQ(a.name, "Hall");
  const ScanInfo b = OpenScan(written.files[1].path)->info();
  EXPECT_THAT(b.guid, ::testing::MatchesRegex("\\{[0-9a-f]{8}-[0-9a-f]{4}-8[0-9a-f]{3}-"
                                              "[89ab][0-9a-f]{3}-[0-9a-f]{12}\\}"));
  EXPECT_EQ(b.name, "B");
  const std::string bytes = ReadBytes(written.files[1].path);
  Write({}, CloudFormat::kE57);
  EXPECT_EQ(ReadBytes(written.files[1].path), bytes);
}

TEST_F(CloudOutputsTest, AGuidStandsForThePointsThatAreThere) {
  const auto guid = [&](const CloudOutput& output) {
    const OutputSource source{ingest_, stations_, network_, ground_, moving_, store_, {}};
    return E57ScansOf({1}, source, output).at(2).guid;
  };
  CloudOutput all = Merged(CloudFormat::kE57, "m.e57");
  CloudOutput still = all;
  still.without_moving = true;
  EXPECT_EQ(guid(still), guid(all));  // nothing moved
  moving_.stations.resize(3);
  moving_.stations[1].points = 7;
  EXPECT_NE(guid(still), guid(all));
  CloudOutput thinned = all;
  thinned.thin_m = 0.1;
  EXPECT_NE(guid(thinned), guid(all));
  EXPECT_NE(guid(thinned), guid(still));
}

TEST_F(CloudOutputsTest, GeoreferencedE57StatesItsTopocentricFrame) {
  TieToUtm();
  const OutputFiles written = Write({}, CloudFormat::kE57);
  const auto scan = ReadWhole(written.files.at(0).path);
  ExpectSamePose(scan.info, *ground_.enu_from_station[0]);
  ExpectSamePoints(scan.points, points_[0]);
  EXPECT_THAT(scan.info.crs, HasSubstr("UTM zone 32N"));
  EXPECT_THAT(scan.info.crs, HasSubstr("origin at latitude 48.1"));
  EXPECT_THAT(scan.info.crs, HasSubstr("topocentric frame (east, north, up)"));
}

TEST_F(CloudOutputsTest, MergedE57HoldsEveryPlacedStation) {
  stations_[1].info.guid = "{A-GUID}";  // as careless copies of a file have it
  const OutputFiles written = Write({Merged(CloudFormat::kE57, "all.e57")}, std::nullopt);
  ASSERT_EQ(written.files.size(), 1U);
  EXPECT_THAT(written.warnings, IsEmpty());
  EXPECT_EQ(written.files[0].points, points_[0].size() + points_[1].size());
  EXPECT_EQ(written.files[0].selection, "") << "all points";
  std::set<std::string> guids;
  for (const int s : {0, 1}) {
    const auto scan = ReadWhole(written.files[0].path, s);
    EXPECT_EQ(scan.info.scan_count, 2);
    guids.insert(scan.info.guid);
    ExpectSamePoints(scan.points, points_[static_cast<std::size_t>(s)]);
    ExpectSamePose(scan.info, network_.survey_from_station[static_cast<std::size_t>(s)]);
  }
  EXPECT_EQ(guids.size(), 2U);
}

TEST_F(CloudOutputsTest, MergedE57IsThinnedAndCroppedLikeOtherClouds) {
  std::vector<CloudOutput> outputs{Merged(CloudFormat::kE57, "all.e57"),
                                   Merged(CloudFormat::kPly, "all.ply")};
  for (CloudOutput& output : outputs) {
    output.thin_m = 2.0;
    output.crop = CropBox{{-10.0, -20.0, -5.0}, {15.0, 20.0, 25.0}};
  }
  const OutputFiles written = Write(outputs, std::nullopt);
  const auto flat = ReadWhole(written.files.at(1).path);
  EXPECT_LT(flat.points.size(), points_[0].size());
  for (const OutputRecord& file : written.files) {
    EXPECT_EQ(file.selection, "the best per cell of 2000 mm, within the crop box");
  }
  std::size_t at = 0;
  for (const int s : {0, 1}) {
    const auto scan = ReadWhole(written.files[0].path, s);
    for (std::size_t i = 0; i < scan.points.size(); ++i, ++at) {
      const Eigen::Vector3d placed =
          *scan.info.world_from_scan *
          Eigen::Vector3d(scan.points.x[i], scan.points.y[i], scan.points.z[i]);
      const Eigen::Vector3d other(flat.points.x.at(at), flat.points.y[at], flat.points.z[at]);
      ASSERT_LT((placed - other).norm(), 1e-12);
    }
  }
  EXPECT_EQ(at, flat.points.size());
}

TEST_F(CloudOutputsTest, PartsOfACloudAreCalledSo) {
  CloudOutput output = Merged(CloudFormat::kLas, "all.las");
  output.without_moving = true;
  output.max_points = static_cast<int>(points_[0].size());
  const OutputFiles written = Write({output}, std::nullopt);
  ASSERT_EQ(written.files.size(), 2U);
  EXPECT_EQ(written.files[0].selection, "without what moved, part 1 of 2");
  EXPECT_EQ(written.files[1].selection, "without what moved, part 2 of 2");
}

TEST_F(CloudOutputsTest, ThinningPrefersTheStationThatFacesTheSurface) {
  // Both see the same wall: A from 10 m at a slant, B from 12 m squarely.
  const std::array<Eigen::Vector3d, 2> scanners{Eigen::Vector3d(2.0, 9.8, 0.0),
                                                Eigen::Vector3d(12.0, 0.0, 0.0)};
  Random random(6);
  for (const std::size_t s : {0U, 1U}) {
    network_.survey_from_station[s] = {Eigen::Matrix3d::Identity(), scanners[s]};
    StationModel& model = stations_[s].model;
    VoxelClusterer clusterer(model.lattice());
    PointChunk& chunk = points_.emplace_back(points_[s]);
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      const Eigen::Vector3d wall(0.0, random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5));
      const Eigen::Vector3d point = wall - scanners[s];
      clusterer.Add(point);
      chunk.x[i] = point.x();
      chunk.y[i] = point.y();
      chunk.z[i] = point.z();
    }
    WriteScan(stations_[s].spec.scan, "", "");
    model.leaves = clusterer.Finish();
    stations_[s].features.normals.assign(model.leaves.size(), Eigen::Vector3f::UnitX());
  }
  CloudOutput output = Merged(CloudFormat::kE57, "all.e57");
  output.thin_m = 0.5;
  const auto only_station = [&] {
    Write({output}, std::nullopt);
    const ScanInfo info = OpenScan(output.path)->info();
    return info.scan_count == 1 ? info.name : "both";
  };
  stations_[0].info = stations_[1].info;  // neither scan has a name of its own
  EXPECT_EQ(only_station(), "B");
  for (Station& station : stations_) station.features.scanner_credible = false;
  EXPECT_EQ(only_station(), "A");  // by range alone
}

TEST_F(CloudOutputsTest, StationCloudsOfOtherFormatsAreInOutputCoordinates) {
  TieToUtm();
  for (const CloudFormat format : {CloudFormat::kLas, CloudFormat::kPly, CloudFormat::kPcd}) {
    const OutputFiles written = Write({}, format);
    ASSERT_EQ(written.files.size(), 2U);
    const auto scan = ReadWhole(written.files[1].path);
    ASSERT_EQ(scan.points.size(), points_[1].size());
    const Eigen::Vector3d expected = ground_.frame->CrsFromEnu(
        *ground_.enu_from_station[1] *
        Eigen::Vector3d(points_[1].x[0], points_[1].y[0], points_[1].z[0]));
    EXPECT_NEAR(scan.points.x[0], expected.x(), 0.51e-4);
    EXPECT_NEAR(scan.points.y[0], expected.y(), 0.51e-4);
    EXPECT_NEAR(scan.points.z[0], expected.z(), 0.51e-4);
    if (format == CloudFormat::kLas) {
      EXPECT_EQ(scan.info.crs, ground_.frame->wkt());
    }
  }
}

TEST_F(CloudOutputsTest, TextScansAreReadByTheirColumns) {
  Station& station = stations_[0];
  station.spec.scan = dir_.File("A.xyz", "3 2 1 7\n6 5 4 7\n");
  station.spec.columns = {TextColumn::kZ, TextColumn::kY, TextColumn::kX, TextColumn::kSkip};
  station.info = OpenScan(station.spec.scan, 0, station.spec.columns)->info();
  const OutputFiles written = Write({}, CloudFormat::kE57);
  const auto scan = ReadWhole(written.files.at(0).path);
  EXPECT_EQ(scan.points.x, (std::vector<double>{1, 4}));
  EXPECT_EQ(scan.points.z, (std::vector<double>{3, 6}));
  EXPECT_TRUE(scan.points.intensity.empty());
}

TEST_F(CloudOutputsTest, AScanThatChangedDuringTheRunEndsInNoCloud) {
  const std::string& path = stations_[1].spec.scan;
  ScanFingerprints scans(store_);
  for (Station& station : stations_) station.scan = scans.Of(station.spec.scan, ExecutionContext{});
  std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now());
  for (const CloudFormat format : {CloudFormat::kLas, CloudFormat::kE57}) {
    EXPECT_EQ(Write({Merged(format, "before")}, std::nullopt).files.size(), 1U);  // same content
  }
  points_.back() = points_[0];
  WriteScan(path, "", "");
  for (const CloudFormat format : {CloudFormat::kLas, CloudFormat::kPly, CloudFormat::kE57}) {
    const CloudOutput output = Merged(format, "after");
    EXPECT_THAT(ErrorOf([&] { Write({output}, std::nullopt); }),
                AllOf(HasSubstr(path), HasSubstr("it changed during the run")));
    EXPECT_FALSE(std::filesystem::exists(output.path));
  }
}

TEST_F(CloudOutputsTest, ACropBoxBesideTheCloudIsNoticed) {
  for (const CloudFormat format : {CloudFormat::kLas, CloudFormat::kE57}) {
    CloudOutput output = Merged(format, format == CloudFormat::kLas ? "a.las" : "a.e57");
    output.crop = CropBox{{5000.0, 0.0, 0.0}, {5001.0, 1.0, 1.0}};
    const OutputFiles written = Write({output}, std::nullopt);
    EXPECT_EQ(written.files.at(0).points, 0U);
    EXPECT_THAT(written.warnings, ElementsAre(HasSubstr("no point is left")));
  }
}

}  // namespace
}  // namespace backsight
