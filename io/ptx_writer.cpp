#include "io/ptx_writer.h"

#include <fmt/format.h>

#include <iterator>

#include "core/error.h"

namespace backsight {
namespace {

std::string Row(const Eigen::Vector3d& v) { return fmt::format("{} {} {}", v.x(), v.y(), v.z()); }

}  // namespace

void PtxWriter::BeginScan(const Scan& scan) {
  BACKSIGHT_CHECK(missing_ == 0, "the scan before is not complete");
  BACKSIGHT_CHECK(scan.columns > 0 && scan.rows > 0, "a PTX scan needs a grid");
  scan_ = scan;
  missing_ = static_cast<std::uint64_t>(scan.columns) * static_cast<std::uint64_t>(scan.rows);
  const auto& [rotation, translation] = scan.world_from_scan;
  std::string text = fmt::format("{}\n{}\n{}\n", scan.columns, scan.rows, Row(translation));
  for (int axis = 0; axis < 3; ++axis) text += Row(rotation.col(axis)) + "\n";
  // The matrix is written transposed: each axis is a row, the translation the last one.
  for (int axis = 0; axis < 3; ++axis) text += Row(rotation.col(axis)) + " 0\n";
  text += Row(translation) + " 1\n";
  file_.Write(text);
}

void PtxWriter::AddPoint(const Eigen::Vector3d& point, double intensity,
                         const std::array<std::uint8_t, 3>& rgb) {
  Count();
  fmt::memory_buffer line;
  fmt::format_to(std::back_inserter(line), "{:.6f} {:.6f} {:.6f} {:.6f}", point.x(), point.y(),
                 point.z(), intensity);
  if (scan_.has_rgb) {
    fmt::format_to(std::back_inserter(line), " {} {} {}", rgb[0], rgb[1], rgb[2]);
  }
  line.push_back('\n');
  file_.Write({line.data(), line.size()});
}

void PtxWriter::AddNoReturn() {
  Count();
  file_.Write(scan_.has_rgb ? "0 0 0 0.5 0 0 0\n" : "0 0 0 0.5\n");
}

void PtxWriter::Finish() {
  BACKSIGHT_CHECK(missing_ == 0, "the scan is not complete");
  file_.Commit();
}

void PtxWriter::Count() {
  BACKSIGHT_CHECK(missing_ > 0, "more records than the scan's grid has cells");
  --missing_;
}

}  // namespace backsight
