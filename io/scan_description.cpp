#include "io/scan_description.h"

#include <fmt/format.h>

#include <numbers>

#include "io/text_fields.h"

namespace backsight {
namespace {

std::string Attributes(const ScanInfo& info) {
  std::string text = "x y z";
  if (info.has_intensity) text += ", intensity";
  if (info.has_rgb) text += ", colour";
  if (info.has_classification) text += ", classification";
  if (info.has_gps_time) text += ", GPS time";
  return text;
}

/// WKT may be laid out over many lines.
std::string OneLine(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool blank = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (!blank) {
      line += c;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  return line;
}

}  // namespace

std::string DescribeScan(const ScanInfo& info) {
  std::string text;
  const auto add = [&text](std::string_view key, std::string_view value) {
    text += fmt::format("{:<12}{}\n", key, value);
  };
  add("file", info.path);
  add("format", info.format);
  add("scan_index", fmt::format("{} (of {})", info.scan_index, info.scan_count));
  if (!info.name.empty()) add("name", Quoted(info.name));
  if (!info.guid.empty()) add("guid", Quoted(info.guid));
  add("points", info.point_count ? fmt::format("{} (declared)", *info.point_count)
                                 : "not declared by this format");
  add("attributes", Attributes(info));
  add("grid", info.rows > 0 ? fmt::format("{} rows, {} columns", info.rows, info.columns)
                            : "none (unstructured)");
  if (info.world_from_scan) {
    const Eigen::Vector3d& t = info.world_from_scan->translation;
    const double angle = RotationAngle(info.world_from_scan->rotation, Eigen::Matrix3d::Identity());
    add("position_m",
        fmt::format("{:.4f} {:.4f} {:.4f} (stated by the file, not applied)", t.x(), t.y(), t.z()));
    add("turned_deg", fmt::format("{:.4f}", angle * 180.0 / std::numbers::pi));
  } else {
    add("pose", "none");
  }
  if (!info.crs.empty()) add("crs", OneLine(info.crs));
  for (const std::string& note : info.notes) add("note", note);
  return text;
}

}  // namespace backsight
