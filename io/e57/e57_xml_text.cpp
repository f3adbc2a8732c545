#include "io/e57/e57_xml_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/utf8.h"

namespace backsight {
namespace {

/// `text` as CDATA. What XML cannot hold becomes "?"; "]]>" is split among two sections.
std::string Cdata(std::string_view text) {
  std::string data = "<![CDATA[";
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = Utf8Length(text, at);
    if (text.substr(at).starts_with("]]>")) {
      data += "]]]]><![CDATA[>";
      at += 3;
    } else if (length == 0) {
      data += '?';
      ++at;
    } else {
      data += text.substr(at, length);
      at += length;
    }
  }
  return data + "]]>";
}

std::string StringXml(std::string_view name, std::string_view text) {
  return fmt::format("<{0} type=\"String\">{1}</{0}>\n", name, Cdata(text));
}

std::string FloatXml(std::string_view name, double value) {
  return fmt::format("<{0} type=\"Float\">{1}</{0}>\n", name, value);
}

std::string IntegerXml(std::string_view name, std::int64_t value) {
  return fmt::format("<{0} type=\"Integer\">{1}</{0}>\n", name, value);
}

std::string StructureXml(std::string_view name, std::string_view children) {
  return fmt::format("<{0} type=\"Structure\">\n{1}</{0}>\n", name, children);
}

std::string IndexBoundsXml(const E57ScanSpec& scan) {
  return StructureXml("indexBounds",
                      IntegerXml("rowMinimum", 0) + IntegerXml("rowMaximum", scan.rows - 1) +
                          IntegerXml("columnMinimum", 0) +
                          IntegerXml("columnMaximum", scan.columns - 1) +
                          IntegerXml("returnMinimum", 0) + IntegerXml("returnMaximum", 0));
}

std::string CartesianBoundsXml(const E57Written& written) {
  std::string bounds;
  for (const int axis : {0, 1, 2}) {
    const char name = "xyz"[axis];
    bounds += FloatXml(fmt::format("{}Minimum", name), written.low[axis]);
    bounds += FloatXml(fmt::format("{}Maximum", name), written.high[axis]);
  }
  return StructureXml("cartesianBounds", bounds);
}

std::string PoseXml(const RigidTransform& pose) {
  const Eigen::Quaterniond q = pose.Quaternion();
  const Eigen::Vector3d& t = pose.translation;
  return StructureXml(
      "pose", StructureXml("rotation", FloatXml("w", q.w()) + FloatXml("x", q.x()) +
                                           FloatXml("y", q.y()) + FloatXml("z", q.z())) +
                  StructureXml("translation",
                               FloatXml("x", t.x()) + FloatXml("y", t.y()) + FloatXml("z", t.z())));
}

std::string ColorLimitsXml(int maximum) {
  std::string limits;
  for (const std::string_view color : {"Red", "Green", "Blue"}) {
    limits += IntegerXml(fmt::format("color{}Minimum", color), 0);
    limits += IntegerXml(fmt::format("color{}Maximum", color), maximum);
  }
  return StructureXml("colorLimits", limits);
}

std::string FieldXml(const E57Field& field) {
  switch (field.type) {
    case E57Type::kInteger:
      return fmt::format("<{} type=\"Integer\" minimum=\"{}\" maximum=\"{}\"/>\n", field.name,
                         field.minimum, field.maximum);
    case E57Type::kScaledInteger:
      return fmt::format(
          "<{} type=\"ScaledInteger\" minimum=\"{}\" maximum=\"{}\" scale=\"{}\" "
          "offset=\"{}\"/>\n",
          field.name, field.minimum, field.maximum, field.scale, field.offset);
    case E57Type::kString:
      return fmt::format("<{} type=\"String\"/>\n", field.name);
    case E57Type::kSingle:
    case E57Type::kDouble:
      break;
  }
  const std::string limits =
      field.limits.low > field.limits.high
          ? ""
          : fmt::format(" minimum=\"{}\" maximum=\"{}\"", field.limits.low, field.limits.high);
  return fmt::format("<{} type=\"Float\" precision=\"{}\"{}/>\n", field.name,
                     field.type == E57Type::kSingle ? "single" : "double", limits);
}

std::string PointsXml(const std::vector<E57Field>& fields, const E57Written& written) {
  std::string prototype;
  for (const E57Field& field : fields) prototype += FieldXml(field);
  return fmt::format(
      "<points type=\"CompressedVector\" fileOffset=\"{}\" recordCount=\"{}\">\n{}"
      "<codecs type=\"Vector\" allowHeterogeneousChildren=\"1\">\n</codecs>\n</points>\n",
      written.file_offset, written.record_count, StructureXml("prototype", prototype));
}

}  // namespace

std::string E57ScanXml(const E57ScanSpec& scan, const std::vector<E57Field>& fields,
                       const E57Written& written) {
  std::string xml = StringXml("guid", scan.guid) + StringXml("name", scan.name);
  if (scan.rows > 0) xml += IndexBoundsXml(scan);
  if (scan.has_intensity) {
    xml += StructureXml("intensityLimits",
                        FloatXml("intensityMinimum", 0.0) + FloatXml("intensityMaximum", 1.0));
  }
  if (scan.has_rgb) xml += ColorLimitsXml(scan.rgb_16_bit ? 65535 : 255);
  if ((written.low.array() <= written.high.array()).all()) xml += CartesianBoundsXml(written);
  xml += PoseXml(scan.world_from_scan) + PointsXml(fields, written);
  return StructureXml("vectorChild", xml);
}

std::string E57RootXml(const E57FileSpec& file, std::string_view scans_xml) {
  std::string xml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<e57Root type=\"Structure\" "
      "xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\">\n";
  xml += StringXml("formatName", "ASTM E57 3D Imaging Data File") + StringXml("guid", file.guid) +
         IntegerXml("versionMajor", 1) + IntegerXml("versionMinor", 0);
  if (!file.generator.empty()) xml += StringXml("e57LibraryVersion", file.generator);
  xml += StringXml("coordinateMetadata", file.crs);
  if (file.creation_gps_s) {
    xml += StructureXml("creationDateTime", FloatXml("dateTimeValue", *file.creation_gps_s) +
                                                IntegerXml("isAtomicClockReferenced", 0));
  }
  xml += fmt::format("<data3D type=\"Vector\" allowHeterogeneousChildren=\"1\">\n{}</data3D>\n",
                     scans_xml);
  return xml +
         "<images2D type=\"Vector\" allowHeterogeneousChildren=\"1\">\n</images2D>\n</e57Root>\n";
}

}  // namespace backsight
