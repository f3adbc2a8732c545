#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "io/csv_table.h"
#include "io/scan_reader.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// The yard in a CRS, scanned coarsely.
std::string YardScene() {
  std::string scene = ReadBytes("tests/e2e/scenes/yard.yaml");
  const std::string fine = "step_deg: 0.3";
  scene.replace(scene.find(fine), fine.size(), "step_deg: 0.4");
  return scene +
         "\ncrs: {horizontal: EPSG:25832, origin: [690000, 5336000, 520], heading_deg: 9}\n";
}

/// Simulates the yard and runs it with these outputs.
void RunYard(const ScratchFolder& folder, const std::string& outputs) {
  WriteBytes(folder / "scene.yaml", YardScene());
  ASSERT_EQ(RunProgram(fmt::format("simulate '{}' '{}'", folder / "scene.yaml", folder / "yard"))
                .exit_code,
            0);
  std::string project = ReadBytes(folder / "yard/yard.yaml");
  const std::size_t merged = project.find("  merged:");
  project.replace(merged, project.find('\n', merged) - merged, outputs);
  WriteBytes(folder / "yard/yard.yaml", project);
  const ProgramRun run = RunProgram(fmt::format("run '{}' --quiet", folder / "yard/yard.yaml"));
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
}

/// How many points of `scan` follow in the same order, bit by bit, among those of `source`.
std::size_t CountInOrder(const PointChunk& scan, const PointChunk& source) {
  std::size_t found = 0;
  for (std::size_t i = 0; i < source.size() && found < scan.size(); ++i) {
    const bool same = source.x[i] == scan.x[found] && source.y[i] == scan.y[found] &&
                      source.z[i] == scan.z[found];
    if (same) ++found;
  }
  return found;
}

RigidTransform EnuFromStation(const CsvTable& table, const CsvTable::Row& row) {
  const auto cell = [&](const std::string& name) { return table.Real(row, "enu_" + name); };
  return RigidTransform::FromQuaternion({cell("qw"), cell("qx"), cell("qy"), cell("qz")},
                                        {cell("tx_m"), cell("ty_m"), cell("tz_m")});
}

TEST(CloudOutputs, StationsAreDeliveredAsE57WithTheirPoses) {
  const ScratchFolder folder;
  ASSERT_NO_FATAL_FAILURE(RunYard(folder,
                                  "  merged: [{format: e57, path: out/all.e57, thin_m: 0.05}]\n"
                                  "  stations: {format: e57, path: out/registered/}"));

  const std::string report = ReadBytes(folder / "yard/out/report.json");
  EXPECT_THAT(report, HasSubstr("out/all.e57"));
  const CsvTable poses = CsvTable::Load(folder / "yard/out/poses.csv");
  ASSERT_EQ(poses.rows().size(), 5U);
  int number = 0;
  for (const CsvTable::Row& row : poses.rows()) {
    const std::string id = poses.Text(row, "station");
    const std::string path = folder / ("yard/out/registered/" + id + ".e57");
    EXPECT_THAT(report, HasSubstr("out/registered/" + id + ".e57"));
    const PointChunk scanned = ReadAllPoints(folder / ("yard/scans/" + id + ".ptx"));
    const PointChunk written = ReadAllPoints(path);
    EXPECT_EQ(CountInOrder(written, scanned), written.size());
    EXPECT_GT(written.size(), scanned.size() * 99 / 100);

    const ScanInfo info = OpenScan(path)->info();
    EXPECT_EQ(info.name, id);
    EXPECT_GT(info.rows, 0);
    EXPECT_THAT(info.crs, HasSubstr("Local topocentric frame of ETRS89 / UTM zone 32N"));
    EXPECT_LT((info.world_from_scan->Matrix() - EnuFromStation(poses, row).Matrix()).norm(), 1e-12);

    const auto part = OpenScan(folder / "yard/out/all.e57", number++);
    EXPECT_EQ(part->info().scan_count, 5);
    EXPECT_NE(part->info().guid, info.guid);  // it holds fewer points
    EXPECT_LT(*part->info().point_count, *info.point_count);
    EXPECT_EQ(part->info().world_from_scan->Matrix(), info.world_from_scan->Matrix());
  }
}

/// Points of each class in a LAS file.
std::map<int, std::uint64_t> CountClasses(const std::string& path) {
  std::map<int, std::uint64_t> counts;
  const auto reader = OpenScan(path);
  PointChunk chunk;
  while (reader->Next(chunk)) {
    for (const std::uint8_t value : chunk.classification) ++counts[value];
  }
  return counts;
}

TEST(CloudOutputs, WhatMovedIsMarkedCountedOrLeftOut) {
  const ScratchFolder folder;
  ASSERT_NO_FATAL_FAILURE(
      RunYard(folder,
              "  merged: [{format: las, path: out/all.las}, {format: las, path: "
              "out/still.las, moving: remove}]\n"
              "  map: {path: out/yard.ot, resolution_m: 0.25}"));

  const auto report = nlohmann::json::parse(ReadBytes(folder / "yard/out/report.json"));
  std::uint64_t moving = 0;
  std::uint64_t points = 0;
  for (const auto& scan : report.at("scans")) {
    moving += scan.at("moving").get<std::uint64_t>();
    points += scan.at("points").get<std::uint64_t>();
  }
  EXPECT_GT(moving, 1000U);
  EXPECT_LT(moving, points / 50);
  const auto all = CountClasses(folder / "yard/out/all.las");
  EXPECT_EQ(all, (std::map<int, std::uint64_t>{{0, points - moving}, {64, moving}}));
  const auto still = CountClasses(folder / "yard/out/still.las");
  EXPECT_EQ(still, (std::map<int, std::uint64_t>{{0, points - moving}}));
  EXPECT_THAT(ReadBytes(folder / "yard/out/yard.ot"), StartsWith("# Octomap OcTree file"));
  EXPECT_THAT(report.at("outputs").back().at("path").get<std::string>(), HasSubstr("yard.ot"));
}

}  // namespace
}  // namespace backsight
