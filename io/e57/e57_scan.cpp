#include "io/e57/e57_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "io/e57/e57_xml.h"
#include "io/text_fields.h"

namespace backsight {
namespace {

constexpr std::uint64_t kMaxGridSide = 10'000'000;
// The lengths of the bytestreams stand in the header of a packet of 64 KB.
constexpr std::size_t kMaxFields = 32'000;

E57Field FieldOf(const E57Element& element, bool standard) {
  E57Field field;
  if (standard) field.name = element.name();
  const std::string_view type = element.type();
  if (type == "Integer" || type == "ScaledInteger") {
    field.type = type == "Integer" ? E57Type::kInteger : E57Type::kScaledInteger;
    field.minimum = element.IntegerAttribute("minimum").value_or(field.minimum);
    field.maximum = element.IntegerAttribute("maximum").value_or(field.maximum);
    if (field.minimum > field.maximum) {
      throw element.Error(fmt::format("minimum {}", field.minimum),
                          fmt::format("at most the maximum, {}", field.maximum));
    }
    if (field.type == E57Type::kScaledInteger) {
      field.scale = element.RealAttribute("scale").value_or(1.0);
      field.offset = element.RealAttribute("offset").value_or(0.0);
      if (field.scale == 0.0) throw element.Error("scale 0", "a scale other than 0");
    }
    const double a = field.Value(field.minimum);
    const double b = field.Value(field.maximum);
    field.limits = {std::min(a, b), std::max(a, b)};
  } else if (type == "Float") {
    const std::string_view precision = element.Attribute("precision");
    if (precision != "" && precision != "single" && precision != "double") {
      throw element.Error(fmt::format("precision {}", Quoted(precision)), "single or double");
    }
    field.type = precision == "single" ? E57Type::kSingle : E57Type::kDouble;
    const auto low = element.RealAttribute("minimum");
    const auto high = element.RealAttribute("maximum");
    if (low && high) field.limits = {*low, *high};
  } else if (type == "String") {
    field.type = E57Type::kString;
  } else {
    throw element.Error(fmt::format("type {}", Quoted(type)),
                        "Integer, ScaledInteger, Float or String, as fields of records are");
  }
  return field;
}

/// The leaves of the prototype, depth first, as their bytestreams are ordered. Extensions may nest
/// structures as deep as they like, so this goes without recursion.
std::vector<E57Field> FieldsOf(const E57Element& prototype) {
  struct Open {
    E57Element element;
    bool standard;
  };
  std::vector<E57Field> fields;
  std::vector<Open> open;
  const auto push = [&open](const E57Element& parent, bool standard) {
    const std::vector<E57Element> children = parent.Children();
    for (auto child = children.rbegin(); child != children.rend(); ++child) {
      open.push_back({*child, standard});
    }
  };
  push(prototype, true);
  while (!open.empty()) {
    const Open next = open.back();
    open.pop_back();
    if (next.element.type() == "Structure" || next.element.type() == "Vector") {
      push(next.element, false);
      continue;
    }
    fields.push_back(FieldOf(next.element, next.standard));
    if (fields.size() <= kMaxFields) continue;
    throw prototype.Error("more fields than a packet can hold",
                          fmt::format("at most {} fields", kMaxFields));
  }
  if (fields.empty()) throw prototype.Error("no fields", "the fields of a point record");
  return fields;
}

std::optional<E57Limits> LimitsOf(const E57Element& parent, std::string_view group,
                                  const std::string& quantity) {
  const E57Element limits = parent.Child(group);
  if (!limits.exists()) return std::nullopt;
  const E57Element low = limits.Child(quantity + "Minimum");
  const E57Element high = limits.Child(quantity + "Maximum");
  if (!low.exists() || !high.exists()) return std::nullopt;
  return E57Limits{low.Real(), high.Real()};
}

/// Cells of the grid along one of its sides; 0 if the file does not tell, or nonsense.
int GridSide(const E57Element& bounds, const std::string& side) {
  if (!bounds.exists()) return 0;
  const E57Element low = bounds.Child(side + "Minimum");
  const E57Element high = bounds.Child(side + "Maximum");
  if (!low.exists() || !high.exists() || high.Integer() < low.Integer()) return 0;
  const std::uint64_t span =
      static_cast<std::uint64_t>(high.Integer()) - static_cast<std::uint64_t>(low.Integer());
  return span < kMaxGridSide ? static_cast<int>(span) + 1 : 0;
}

/// Rows and columns, if the records say in which cell they are.
void ReadGrid(const E57Element& data, E57Scan& scan) {
  bool has_row = false;
  bool has_column = false;
  for (const E57Field& field : scan.fields) {
    if (field.type == E57Type::kString) continue;
    has_row = has_row || field.name == "rowIndex";
    has_column = has_column || field.name == "columnIndex";
  }
  if (!has_row || !has_column) return;
  const E57Element bounds = data.Child("indexBounds");
  const int rows = GridSide(bounds, "row");
  const int columns = GridSide(bounds, "column");
  if (rows == 0 || columns == 0) return;
  scan.rows = rows;
  scan.columns = columns;
  scan.first_row = bounds.Child("rowMinimum").Integer();
  scan.first_column = bounds.Child("columnMinimum").Integer();
}

void ReadPose(const E57Element& data, E57Scan& scan) {
  const E57Element pose = data.Child("pose");
  if (!pose.exists()) return;
  const auto number = [](const E57Element& parent, std::string_view name) {
    const E57Element child = parent.Child(name);
    return child.exists() ? child.Real() : 0.0;
  };
  const E57Element t = pose.Child("translation");
  if (t.exists()) {
    scan.world_from_scan.translation = {number(t, "x"), number(t, "y"), number(t, "z")};
  }
  const E57Element r = pose.Child("rotation");
  if (!r.exists()) return;
  Eigen::Vector4d wxyz(number(r, "w"), number(r, "x"), number(r, "y"), number(r, "z"));
  const double largest = wxyz.cwiseAbs().maxCoeff();
  if (largest == 0.0) {
    scan.notes.emplace_back("the rotation of the pose is a quaternion of zeros: taken as identity");
    return;
  }
  const double norm = wxyz.stableNorm();
  constexpr double kTolerance = 1e-6;  // files carry as few as seven digits
  if (std::abs(norm - 1.0) > kTolerance) {
    scan.notes.push_back(
        fmt::format("the rotation of the pose is a quaternion of length {:.6g}: normalised", norm));
  }
  wxyz = (wxyz / largest).normalized();
  scan.world_from_scan.rotation =
      Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).toRotationMatrix();
}

/// Bit packing is the one codec of the standard (clause 8.3.7), used where none is named.
void CheckCodecs(const E57Element& codecs) {
  if (!codecs.exists()) return;
  for (const E57Element& codec : codecs.Children()) {
    if (!codec.Child("bitPackCodec").exists()) {
      throw codec.Error("another codec", "'bitPackCodec', the one of the standard");
    }
  }
}

void ReadPoints(const E57Element& points, E57Scan& scan) {
  if (points.type() != "CompressedVector") {
    throw points.Error(fmt::format("type {}", Quoted(points.type())), "type 'CompressedVector'");
  }
  const auto count = [&points](std::string_view name) {
    const std::optional<std::int64_t> value = points.IntegerAttribute(name);
    if (!value || *value < 0) {
      throw points.Error(fmt::format("{} {}", name, Quoted(points.Attribute(name))),
                         "a number of bytes or records");
    }
    return static_cast<std::uint64_t>(*value);
  };
  scan.points = {count("fileOffset"), count("recordCount"), points.offset()};
  scan.fields = FieldsOf(points.Require("prototype"));
  CheckCodecs(points.Child("codecs"));
}

}  // namespace

E57Scan ReadE57Scan(PagedFile& file, int scan_index) {
  const E57Xml xml(file);
  const std::vector<E57Element> scans = xml.root().Require("data3D").Children();
  const auto count = static_cast<int>(scans.size());
  if (scan_index < 0 || scan_index >= count) {
    throw InputError(
        {file.path(), fmt::format("no scan with index {}", scan_index),
         count == 0 ? "a file with scans" : fmt::format("a scan_index from 0 to {}", count - 1),
         count == 0 ? "export the scans, not only images" : "correct scan_index"});
  }
  const E57Element& data = scans[static_cast<std::size_t>(scan_index)];
  E57Scan scan;
  scan.scan_count = count;
  const auto text = [&data](std::string_view name) {
    const E57Element child = data.Child(name);
    return child.exists() ? child.Text() : "";
  };
  scan.guid = text("guid");
  scan.name = text("name");
  const E57Element crs = xml.root().Child("coordinateMetadata");
  if (crs.exists()) scan.crs = crs.Text();
  ReadPoints(data.Require("points"), scan);
  ReadGrid(data, scan);
  ReadPose(data, scan);
  scan.intensity_limits = LimitsOf(data, "intensityLimits", "intensity");
  scan.color_limits = {LimitsOf(data, "colorLimits", "colorRed"),
                       LimitsOf(data, "colorLimits", "colorGreen"),
                       LimitsOf(data, "colorLimits", "colorBlue")};
  return scan;
}

}  // namespace backsight
