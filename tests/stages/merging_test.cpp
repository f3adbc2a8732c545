#include "stages/merging.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <map>

namespace backsight {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Points along the x axis, one chunk each.
class LineScan : public ScanReader {
 public:
  LineScan(std::vector<double> x, bool has_cells) : x_(std::move(x)), has_cells_(has_cells) {}
  const ScanInfo& info() const override { return info_; }
  const ScanTally& tally() const override { return tally_; }
  bool Next(PointChunk& chunk) override {
    chunk.Clear();
    if (next_ == x_.size()) return false;
    chunk.x = {x_[next_]};
    chunk.y = {0.0};
    chunk.z = {0.0};
    if (has_cells_) {
      chunk.row = {static_cast<std::int32_t>(next_)};
      chunk.column = {7};
    }
    ++next_;
    return true;
  }

 private:
  std::vector<double> x_;
  bool has_cells_;
  std::size_t next_ = 0;
  ScanInfo info_;
  ScanTally tally_;
};

/// Keeps what it is given, by station.
class KeepingWriter : public CloudWriter {
 public:
  void Write(const PointChunk& chunk, int station_number) override {
    PointChunk& to = chunks[station_number];
    to.x.insert(to.x.end(), chunk.x.begin(), chunk.x.end());
    to.row.insert(to.row.end(), chunk.row.begin(), chunk.row.end());
    to.column.insert(to.column.end(), chunk.column.begin(), chunk.column.end());
    to.classification.insert(to.classification.end(), chunk.classification.begin(),
                             chunk.classification.end());
  }
  std::uint64_t Finish() override { return 0; }

  std::map<int, PointChunk> chunks;
};

MergeStation Line(int number, double shift, std::vector<double> x, bool has_cells = false) {
  MergeStation station;
  station.number = number;
  station.frame_from_station.translation.x() = shift;
  station.min.setConstant(-100.0);
  station.max.setConstant(100.0);
  station.max_range_m = 50.0;
  station.open = [x, has_cells] { return std::make_unique<LineScan>(x, has_cells); };
  return station;
}

MergeOptions Crop(double min_x, double max_x) {
  MergeOptions options;
  options.crop = CropBox{{min_x, -1.0, -1.0}, {max_x, 1.0, 1.0}};
  return options;
}

/// Everything that a writer is given, in its order.
class RecordingWriter : public CloudWriter {
 public:
  void Write(const PointChunk& chunk, int station_number) override {
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      points.push_back({static_cast<double>(station_number), chunk.x[i], chunk.y[i], chunk.z[i]});
    }
  }
  std::uint64_t Finish() override { return points.size(); }

  std::vector<std::array<double, 4>> points;
};

TEST(MergeClouds, TheSameForAnyNumberOfThreads) {
  std::vector<double> x;
  for (int i = 0; i < 3000; ++i) x.push_back(std::fmod(0.37 * i, 60.0));
  const std::vector<MergeStation> stations{Line(1, 10.0, x), Line(2, -3.0, x)};
  for (const double thin_m : {0.0, 0.2}) {
    std::vector<std::array<double, 4>> first;
    for (const int threads : {1, 2, 5}) {
      MergeOptions options = Crop(-2.0, 55.0);
      options.thin_m = thin_m;
      options.thinning.path = "threads";
      RecordingWriter writer;
      const ExecutionContext context(threads);
      const std::uint64_t written = MergeClouds(stations, options, writer, context);
      EXPECT_EQ(written, writer.points.size());
      if (threads == 1) first = writer.points;
      EXPECT_GT(writer.points.size(), 200U);
      EXPECT_EQ(writer.points, first) << thin_m << " " << threads;
    }
  }
}

TEST(MergeClouds, KeepsCellsWhereAScanHasThem) {
  KeepingWriter writer;
  EXPECT_EQ(MergeClouds({Line(1, 10.0, {1, 60, 3}, true), Line(2, 0.0, {5})}, {}, writer,
                        ExecutionContext{}),
            3U);
  EXPECT_THAT(writer.chunks[1].x, ElementsAre(11, 13));
  EXPECT_THAT(writer.chunks[1].row, ElementsAre(0, 2));
  EXPECT_THAT(writer.chunks[1].column, ElementsAre(7, 7));
  EXPECT_THAT(writer.chunks[2].row, IsEmpty());
}

TEST(MergeClouds, PointsOfStationFramesAreWhatWasScannedTimesTheScale) {
  for (const double scale : {1.0, 1.5}) {
    MergeStation station = Line(1, 0.1, {0.1, 0.7, 3.3});
    station.scale = scale;
    MergeOptions options = Crop(0.0, 0.1 + scale);
    options.in_station_frames = true;
    KeepingWriter writer;
    MergeClouds({station}, options, writer, ExecutionContext{});
    EXPECT_THAT(writer.chunks[1].x, ElementsAre(scale * 0.1, scale * 0.7));
  }
}

TEST(MergeClouds, CropsInTheCoordinatesOfTheOutput) {
  MergeOptions options = Crop(1002.0, 1003.0);
  options.map = [](std::span<Eigen::Vector3d> points) {
    for (Eigen::Vector3d& p : points) p.x() += 1000.0;
  };
  const std::vector<MergeStation> stations{Line(1, 0.0, {1, 2, 3, 4}), Line(2, 1.0, {1, 2, 9})};
  KeepingWriter writer;
  EXPECT_EQ(MergeClouds(stations, options, writer, ExecutionContext{}), 4U);
  EXPECT_THAT(writer.chunks[1].x, ElementsAre(1002, 1003));
  EXPECT_THAT(writer.chunks[2].x, ElementsAre(1002, 1003));
  const CloudBounds bounds = MergedBounds(stations, options);
  EXPECT_EQ(bounds.min.x(), 1002.0);
  EXPECT_EQ(bounds.max.x(), 1003.0);
  const CloudBounds beside = MergedBounds(stations, Crop(5000.0, 5001.0));
  EXPECT_TRUE((beside.min.array() <= beside.max.array()).all());
}

TEST(MergeClouds, ThinsWhatTheCropBoxLeaves) {
  // Without the box 0.2 would stand for its cell, as the one nearest to its scanner.
  const std::vector<MergeStation> stations{Line(1, 0.0, {0.2, 0.6, 0.8, 1.4})};
  MergeOptions options = Crop(0.5, 9.0);
  options.thin_m = 1.0;
  KeepingWriter writer;
  EXPECT_EQ(MergeClouds(stations, options, writer, ExecutionContext{}), 2U);
  EXPECT_THAT(writer.chunks[1].x, ElementsAre(0.6, 1.4));
}

/// What lies beyond 2 m has moved.
MergeStation WithMoving(MergeStation station) {
  station.is_moving = [](const Eigen::Vector3d& point) { return point.x() > 2.0; };
  return station;
}

TEST(MergeClouds, PointsOfWhatMovedGetTheirClass) {
  KeepingWriter writer;
  MergeClouds({WithMoving(Line(1, 10.0, {1, 3, 2})), Line(2, 0.0, {5})}, {}, writer,
              ExecutionContext{});
  EXPECT_THAT(writer.chunks[1].x, ElementsAre(11, 13, 12));
  EXPECT_THAT(writer.chunks[1].classification, ElementsAre(0, kMovingClass, 0));
  EXPECT_THAT(writer.chunks[2].classification, IsEmpty());
}

TEST(MergeClouds, LeavesOutWhatMovedWhereAskedTo) {
  for (const double thin_m : {0.0, 0.5}) {
    MergeOptions options;
    options.without_moving = true;
    options.thin_m = thin_m;
    options.thinning.path = "moving";
    KeepingWriter writer;
    EXPECT_EQ(
        MergeClouds({WithMoving(Line(1, 0.0, {1, 3, 2}))}, options, writer, ExecutionContext{}),
        2U);
    EXPECT_THAT(writer.chunks[1].x, ElementsAre(1, 2));
  }
}

TEST(MergeClouds, WhatMovedStandsForACellOnlyWhereNothingElseDoes) {
  // Both stations see a cell; the one that is nearer to it saw what moved.
  MergeOptions options;
  options.thin_m = 1.0;
  options.thinning.path = "moving";
  KeepingWriter writer;
  MergeClouds({WithMoving(Line(1, 20.0, {3.25, 7.75, 7.25})), Line(2, 0.0, {23.75})}, options,
              writer, ExecutionContext{});
  EXPECT_THAT(writer.chunks[1].x, ElementsAre(27.25));  // the nearest of what moved
  EXPECT_THAT(writer.chunks[2].x, ElementsAre(23.75));
}

}  // namespace
}  // namespace backsight
