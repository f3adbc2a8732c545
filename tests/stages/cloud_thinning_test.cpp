#include "stages/cloud_thinning.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <map>
#include <tuple>

#include "stages/merging.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

using Points = std::vector<Eigen::Vector3d>;
constexpr std::size_t kChunk = 100;

class PointScan : public ScanReader {
 public:
  explicit PointScan(const Points& points) : points_(points) { info_.path = "scan.ply"; }
  const ScanInfo& info() const override { return info_; }
  const ScanTally& tally() const override { return tally_; }
  bool Next(PointChunk& chunk) override {
    chunk.Clear();
    for (; next_ < points_.size() && chunk.size() < kChunk; ++next_) {
      chunk.x.push_back(points_[next_].x());
      chunk.y.push_back(points_[next_].y());
      chunk.z.push_back(points_[next_].z());
    }
    return !chunk.empty();
  }

 private:
  Points points_;
  std::size_t next_ = 0;
  ScanInfo info_;
  ScanTally tally_;
};

struct Kept {
  int station = 0;
  Eigen::Vector3d point;
  bool operator==(const Kept&) const = default;
};

class KeepingWriter : public CloudWriter {
 public:
  void Write(const PointChunk& chunk, int station_number) override {
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      kept.push_back({station_number, {chunk.x[i], chunk.y[i], chunk.z[i]}});
    }
  }
  std::uint64_t Finish() override { return kept.size(); }

  std::vector<Kept> kept;
};

MergeStation StationOf(int number, const RigidTransform& frame_from_station, Points points) {
  MergeStation station;
  station.number = number;
  station.frame_from_station = frame_from_station;
  station.min.setConstant(-9.5);
  station.max.setConstant(9.5);
  station.min_range_m = 1.0;
  station.max_range_m = 14.0;
  station.open = [points = std::move(points)] { return std::make_unique<PointScan>(points); };
  return station;
}

/// Some angle for each point, unknown for one in nine.
std::optional<double> SomeCos(const Eigen::Vector3d& point) {
  const double share = point.norm() * 1e4 - std::floor(point.norm() * 1e4);
  if (share > 8.0 / 9.0) return std::nullopt;
  return share;
}

/// Stations about the origin of the shared frame. Points of a raster of 1/16 m repeat and lie on
/// borders of cells; the first stations stand upright, so that theirs are borders there too.
std::vector<MergeStation> RandomStations(bool with_incidence) {
  Random random(7);
  std::vector<MergeStation> stations;
  for (int s = 0; s < 4; ++s) {
    Points points;
    for (int i = 0; i < 5000; ++i) {
      Eigen::Vector3d p(random.Uniform(-10, 10), random.Uniform(-10, 10), random.Uniform(-2, 2));
      if (i % 2 == 0) p = (16.0 * p).array().round() / 16.0;
      points.push_back(p);
    }
    RigidTransform pose;
    if (s > 1) pose.rotation = random.Rotation();
    pose.translation = {-3.0 * s, 2.0 * s, -1.0};
    stations.push_back(StationOf(10 - s, pose, std::move(points)));
    if (with_incidence) stations.back().cos_incidence = &SomeCos;
  }
  stations[3].scale = 1.01;
  return stations;
}

/// The cell by integer division of its own, of the lattice about the rounded middle of the bounds.
std::array<std::int64_t, 3> CellOf(const Eigen::Vector3d& placed,
                                   const std::vector<MergeStation>& stations, double thin_m) {
  const CloudBounds bounds = MergedBounds(stations, {});
  std::array<std::int64_t, 3> cell{};
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = std::round(0.5 * (bounds.min[axis] + bounds.max[axis]));
    cell[static_cast<std::size_t>(axis)] =
        static_cast<std::int64_t>(std::floor((placed[axis] - origin) / thin_m));
  }
  return cell;
}

/// All points in memory, the best of each cell, in the order of writing.
std::vector<Kept> ThinnedInMemory(const std::vector<MergeStation>& stations,
                                  const MergeOptions& options) {
  using Rank = std::tuple<float, std::size_t, std::size_t>;  // uncertainty, station, point
  std::map<std::array<std::int64_t, 3>, std::pair<Rank, Kept>> best;
  for (std::size_t s = 0; s < stations.size(); ++s) {
    const MergeStation& station = stations[s];
    const auto reader = station.open();
    std::size_t index = 0;
    for (PointChunk chunk; reader->Next(chunk);) {
      for (std::size_t i = 0; i < chunk.size(); ++i, ++index) {
        const Eigen::Vector3d p(chunk.x[i], chunk.y[i], chunk.z[i]);
        if (p.norm() < 1.0 || p.norm() > 14.0 || p.cwiseAbs().maxCoeff() > 9.5) continue;
        const Eigen::Vector3d placed = station.frame_from_station * (station.scale * p);
        Eigen::Vector3d output = placed;
        if (options.map) options.map({&output, 1});
        if (options.crop && ((output.array() < options.crop->min.array()).any() ||
                             (output.array() > options.crop->max.array()).any())) {
          continue;
        }
        std::optional<double> cos;
        if (station.cos_incidence) cos = station.cos_incidence(p);
        const double uncertainty = p.norm() / std::max(0.2, cos.value_or(0.5));
        const Rank rank{static_cast<float>(uncertainty), s, index};
        const Kept kept{station.number,
                        options.in_station_frames ? Eigen::Vector3d(station.scale * p) : output};
        const auto [at, is_new] =
            best.try_emplace(CellOf(placed, stations, options.thin_m), rank, kept);
        if (!is_new && rank < at->second.first) at->second = {rank, kept};
      }
    }
  }
  std::map<std::pair<std::size_t, std::size_t>, Kept> by_place;
  for (const auto& [cell, entry] : best) {
    by_place[{std::get<1>(entry.first), std::get<2>(entry.first)}] = entry.second;
  }
  std::vector<Kept> result;
  result.reserve(by_place.size());
  for (const auto& [place, kept] : by_place) result.push_back(kept);
  return result;
}

class CloudThinningTest : public ::testing::Test {
 protected:
  MergeOptions Thin(double thin_m, std::size_t memory_bytes) const {
    MergeOptions options;
    options.thin_m = thin_m;
    options.thinning = {dir_ / "merged.las", memory_bytes};
    return options;
  }

  static std::vector<Kept> Merged(const std::vector<MergeStation>& stations,
                                  const MergeOptions& options, int threads = 1) {
    KeepingWriter writer;
    const std::uint64_t written = MergeClouds(stations, options, writer, ExecutionContext(threads));
    EXPECT_EQ(written, writer.kept.size());
    return writer.kept;
  }

  TempDir dir_;
};

TEST_F(CloudThinningTest, KeepsTheBestOfEachCellWhateverTheMemory) {
  for (const bool with_incidence : {false, true}) {
    const std::vector<MergeStation> stations = RandomStations(with_incidence);
    for (const double thin_m : {0.125, 0.5, 3.0, 10.0}) {
      const std::vector<Kept> expected = ThinnedInMemory(stations, Thin(thin_m, 0));
      for (const std::size_t bytes : {100U, 5000U, 100000U, 100000000U}) {
        EXPECT_EQ(Merged(stations, Thin(thin_m, bytes)), expected)
            << thin_m << " m, " << bytes << " bytes";
      }
    }
  }
  EXPECT_EQ(dir_.FileCount(), 0U);
}

TEST_F(CloudThinningTest, NoThreadAndNoRepetitionChangesTheChoice) {
  const std::vector<MergeStation> stations = RandomStations(true);
  const std::vector<Kept> once = Merged(stations, Thin(0.25, 2000));
  EXPECT_EQ(Merged(stations, Thin(0.25, 2000), 2), once);
  EXPECT_EQ(Merged(stations, Thin(0.25, 2000), 3), once);
}

TEST_F(CloudThinningTest, HoldsOnePointPerCell) {
  const std::vector<MergeStation> stations = RandomStations(true);
  std::map<std::array<std::int64_t, 3>, int> points;
  for (const Kept& kept : Merged(stations, Thin(0.25, 2000))) {
    EXPECT_EQ(++points[CellOf(kept.point, stations, 0.25)], 1);
  }
  EXPECT_GT(points.size(), 5000U);
}

TEST_F(CloudThinningTest, ThinsWhatTheCropBoxLeavesInStationAndOutputFrames) {
  const std::vector<MergeStation> stations = RandomStations(true);
  MergeOptions options = Thin(0.5, 2000);
  options.map = [](std::span<Eigen::Vector3d> points) {
    for (Eigen::Vector3d& p : points) p = Eigen::Vector3d(2.0 * p.y(), p.x(), p.z());
  };
  options.crop = CropBox{{-9.0, -7.0, -4.0}, {11.0, 8.0, 1.0}};
  const std::vector<Kept> flat = Merged(stations, options);
  EXPECT_EQ(flat, ThinnedInMemory(stations, options));
  options.in_station_frames = true;
  const std::vector<Kept> scans = Merged(stations, options);
  EXPECT_EQ(scans, ThinnedInMemory(stations, options));
  EXPECT_EQ(scans.size(), flat.size());
  EXPECT_GT(scans.size(), 100U);
}

TEST_F(CloudThinningTest, AmongEqualsTheFirstStationsFirstPointStays) {
  Points points;
  for (int i = 0; i < 3000; ++i) points.emplace_back(3.0, i % 3 - 1.0, i % 2 + 0.5);
  const std::vector<MergeStation> stations{StationOf(5, {}, points), StationOf(2, {}, points)};
  for (const std::size_t bytes : {100U, 1000000U}) {
    CloudThinning thinning({.edge_m = 0.5}, {dir_ / "merged.las", bytes});
    for (std::size_t s = 0; s < 2; ++s) {
      for (std::size_t i = 0; i < points.size(); ++i) thinning.Offer({s, i}, points[i], 7.0);
    }
    thinning.Choose(ExecutionContext{});
    std::vector<std::pair<std::size_t, std::size_t>> taken;
    for (std::size_t s = 0; s < 2; ++s) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (thinning.Takes({s, i})) taken.emplace_back(s, i);
      }
    }
    EXPECT_EQ(taken, (std::vector<std::pair<std::size_t, std::size_t>>{
                         {0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}}));
    for (const Kept& kept : Merged(stations, Thin(0.5, bytes))) EXPECT_EQ(kept.station, 5);
  }
}

TEST_F(CloudThinningTest, AWellHitPointFarAwayBeatsAGrazedOneNearby) {
  const RigidTransform behind{Eigen::Matrix3d::Identity(), {-2.0, 0.0, 0.0}};
  std::vector<MergeStation> stations{StationOf(1, {}, {{4.0, 0.1, 0.1}}),
                                     StationOf(2, behind, {{6.0, 0.2, 0.2}})};
  stations[0].cos_incidence = [](const Eigen::Vector3d&) { return 0.3; };
  const auto station_of_the_point = [&](double cos_of_second) {
    stations[1].cos_incidence = [=](const Eigen::Vector3d&) { return cos_of_second; };
    const std::vector<Kept> kept = Merged(stations, Thin(1.0, 1000));
    return kept.size() == 1 ? kept[0].station : 0;
  };
  EXPECT_EQ(station_of_the_point(0.9), 2);   // 6.7 m against 13.3 m
  EXPECT_EQ(station_of_the_point(0.44), 1);  // 13.6 m
  EXPECT_EQ(station_of_the_point(0.46), 2);  // 13.0 m
  stations[0].cos_incidence = {};            // counts as 0.5: 8 m
  EXPECT_EQ(station_of_the_point(0.7), 1);   // 8.6 m
  EXPECT_EQ(station_of_the_point(0.8), 2);   // 7.5 m
}

TEST_F(CloudThinningTest, UncertaintyGrowsWithRangeAndSlantUpToAFloor) {
  EXPECT_DOUBLE_EQ(PointUncertainty(10.0, 1.0), 10.0);
  EXPECT_DOUBLE_EQ(PointUncertainty(10.0, 0.25), 40.0);
  EXPECT_DOUBLE_EQ(PointUncertainty(10.0, 0.2), 50.0);
  EXPECT_DOUBLE_EQ(PointUncertainty(10.0, 0.0), 50.0);
  EXPECT_DOUBLE_EQ(PointUncertainty(10.0, std::nullopt), 20.0);
}

TEST_F(CloudThinningTest, NothingIsLeftWhenTheWriterFails) {
  class FullWriter : public CloudWriter {
   public:
    explicit FullWriter(const TempDir& dir) : dir_(dir) {}
    void Write(const PointChunk&, int) override {
      EXPECT_EQ(dir_.FileCount(), 0U);  // not even meanwhile
      throw InputError({"merged.las", "writing failed", "", ""});
    }
    std::uint64_t Finish() override { return 0; }

   private:
    const TempDir& dir_;
  };
  FullWriter writer(dir_);
  EXPECT_THROW(MergeClouds(RandomStations(false), Thin(0.125, 2000), writer, ExecutionContext{}),
               InputError);
  EXPECT_EQ(dir_.FileCount(), 0U);
}

TEST_F(CloudThinningTest, AFullDiskIsNamedAndLeavesNothing) {
  // A limit on file size stands in for a full disk: both make the write itself fail.
  struct rlimit old {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const struct rlimit small { 50000, old.rlim_max };
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string error = ErrorOf([&] { Merged(RandomStations(false), Thin(0.125, 2000)); });
  ::setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(error, HasSubstr("merged.las: writing failed: File too large; free disk space"));
  EXPECT_EQ(dir_.FileCount(), 0U);
}

TEST_F(CloudThinningTest, AScanThatChangesBetweenItsReadingsIsRefused) {
  MergeStation station = StationOf(1, {}, {});
  auto readings = std::make_shared<int>(0);
  station.open = [readings] {
    Points points{{2.0, 0.0, 0.0}, {3.0, 0.0, 0.0}, {5.0, 0.0, 0.0}};
    if (++*readings > 1) points.pop_back();
    return std::make_unique<PointScan>(points);
  };
  EXPECT_THAT(ErrorOf([&] { Merged({station}, Thin(0.5, 1000)); }),
              HasSubstr("scan.ply: 2 usable points when it was read again; expected 3"));
}

}  // namespace
}  // namespace backsight
