#include "io/ply_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <vector>

#include "io/line_reader.h"
#include "io/ply_header.h"
#include "io/point_collector.h"
#include "io/text_fields.h"

namespace backsight {
namespace {

/// Indices of the vertex properties in use.
struct VertexMap {
  static constexpr std::size_t kNone = SIZE_MAX;
  std::array<std::size_t, 3> xyz{kNone, kNone, kNone};
  std::size_t intensity = kNone;
  std::array<std::size_t, 3> rgb{kNone, kNone, kNone};
};

std::size_t FindScalar(const PlyElement& element, std::initializer_list<std::string_view> names) {
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    if (!property.is_list && std::find(names.begin(), names.end(), property.name) != names.end()) {
      return i;
    }
  }
  return VertexMap::kNone;
}

/// Steps through the records of an element, whatever their layout.
class RecordReader {
 public:
  RecordReader(LineReader& lines, PlyEncoding encoding)
      : lines_(lines), source_(lines.source()), encoding_(encoding) {
    if (encoding == PlyEncoding::kAscii) words_.resize(LineReader::kMaxLineBytes / 2 + 1);
  }

  /// Reads one record; scalars go to values[i] of property i. `done` records came before it.
  void Read(const PlyElement& element, std::uint64_t done, std::vector<double>& values) {
    if (encoding_ == PlyEncoding::kAscii) {
      ReadLine(element, done, values);
    } else if (element.has_list) {
      ReadWithLists(element, done, values);
    } else {
      const std::string_view ahead = Require(element, done, element.record_bytes);
      for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = LoadScalar(ahead.data() + element.properties[i].offset,
                               element.properties[i].type, Order());
      }
      source_.Consume(element.record_bytes);
    }
  }

  void SkipElement(const PlyElement& element) {
    if (encoding_ == PlyEncoding::kAscii) {
      const std::uint64_t skipped = lines_.Skip(element.count);
      if (skipped < element.count) throw Truncated(element, skipped);
    } else if (element.has_list) {
      RequireAll(element);
      std::vector<double> values(element.properties.size());
      for (std::uint64_t i = 0; i < element.count; ++i) ReadWithLists(element, i, values);
    } else {
      RequireAll(element);
      source_.Seek(source_.position() + element.count * element.record_bytes);
    }
  }

  /// Throws if the file is too short for `element`, as far as that can be told beforehand.
  void RequireAll(const PlyElement& element) const {
    std::uint64_t bytes = element.record_bytes;
    if (encoding_ == PlyEncoding::kAscii) bytes = element.properties.empty() ? 0 : 1;
    if (element.has_list) bytes = 1;
    if (bytes == 0) return;
    const std::uint64_t available = source_.remaining() / bytes;
    if (available < element.count) throw Truncated(element, available);
  }

 private:
  std::endian Order() const {
    return encoding_ == PlyEncoding::kBigEndian ? std::endian::big : std::endian::little;
  }

  InputError Truncated(const PlyElement& element, std::uint64_t available) const {
    return source_.Truncated(source_.position(), "records of element " + Quoted(element.name),
                             element.count, available);
  }

  std::string_view Require(const PlyElement& element, std::uint64_t done, std::size_t bytes) {
    const std::string_view ahead = source_.Peek(bytes);
    if (ahead.size() < bytes) throw Truncated(element, done);
    return ahead;
  }

  double TakeScalar(const PlyElement& element, std::uint64_t done, ScalarType type) {
    const std::size_t bytes = SizeOf(type);
    const double value = LoadScalar(Require(element, done, bytes).data(), type, Order());
    source_.Consume(bytes);
    return value;
  }

  void ReadWithLists(const PlyElement& element, std::uint64_t done, std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      if (!property.is_list) {
        values[i] = TakeScalar(element, done, property.type);
        continue;
      }
      const std::uint64_t at = source_.position();
      const double entries = TakeScalar(element, done, property.count_type);
      const std::uint64_t room = source_.remaining() / SizeOf(property.type);
      if (!(entries >= 0.0 && entries <= static_cast<double>(room))) {
        throw source_.Error(
            at, fmt::format("a list {} of {} entries", Quoted(property.name), entries),
            fmt::format("0 to {} entries, as many as the rest of the file can hold", room),
            "the file is damaged or cut short: export it again");
      }
      source_.Seek(source_.position() +
                   static_cast<std::uint64_t>(entries) * SizeOf(property.type));
    }
  }

  void ReadLine(const PlyElement& element, std::uint64_t done, std::vector<double>& values) {
    std::string_view line;
    if (!lines_.Next(line)) throw Truncated(element, done);
    const std::size_t count = SplitFields(line, ' ', words_);
    std::size_t word = 0;
    for (std::size_t i = 0; i < values.size() && word < count; ++i) {
      values[i] = Number(words_[word++]);
      if (!element.properties[i].is_list) continue;
      if (!(values[i] >= 0.0 && values[i] <= static_cast<double>(count - word))) {
        word = count + 1;
        break;
      }
      word += static_cast<std::size_t>(values[i]);
    }
    if (word != count || count < values.size()) {
      throw lines_.Error(
          fmt::format("{} values: {}", count, Quoted(line)),
          fmt::format("the {} properties of {}", values.size(), Quoted(element.name)),
          "the line is damaged");
    }
  }

  double Number(std::string_view word) const {
    const std::optional<double> number = ParseNumber(word);
    if (!number) throw lines_.Error(Quoted(word), "a number", "the line is damaged");
    return *number;
  }

  LineReader& lines_;
  ByteSource& source_;
  PlyEncoding encoding_;
  std::vector<std::string_view> words_;
};

class PlyReader : public ScanReader {
 public:
  explicit PlyReader(const std::string& path)
      : source_(path),
        lines_(source_),
        header_(ReadPlyHeader(lines_)),
        records_(lines_, header_.encoding) {
    FindVertex();
    MapProperties();
    for (std::size_t i = 0; i < vertex_index_; ++i) records_.SkipElement(header_.elements[i]);
    records_.RequireAll(Vertex());
    values_.resize(Vertex().properties.size());
    info_.path = path;
    info_.format = "PLY";
    info_.point_count = Vertex().count;
  }

  const ScanInfo& info() const override { return info_; }
  const ScanTally& tally() const override { return collector_.tally(); }

  bool Next(PointChunk& chunk) override {
    chunk.Clear();
    if (done_ == Vertex().count) return false;
    const std::uint64_t n = std::min<std::uint64_t>(kChunkRecords, Vertex().count - done_);
    for (std::uint64_t i = 0; i < n; ++i, ++done_) {
      records_.Read(Vertex(), done_, values_);
      Add(chunk);
    }
    if (done_ == Vertex().count) collector_.Finish();
    return true;
  }

 private:
  const PlyElement& Vertex() const { return header_.elements[vertex_index_]; }

  void FindVertex() {
    while (vertex_index_ < header_.elements.size() && Vertex().name != "vertex") ++vertex_index_;
    if (vertex_index_ < header_.elements.size()) return;
    throw lines_.Error("no element 'vertex'", "a point cloud", "export the points as PLY vertices");
  }

  void MapProperties() {
    const PlyElement& vertex = Vertex();
    map_.xyz = {FindScalar(vertex, {"x"}), FindScalar(vertex, {"y"}), FindScalar(vertex, {"z"})};
    for (const std::size_t i : map_.xyz) {
      if (i != VertexMap::kNone) continue;
      throw lines_.Error("element 'vertex' lacks a coordinate", "properties x, y and z",
                         "export the cloud with its coordinates");
    }
    map_.intensity = FindScalar(vertex, {"intensity", "scalar_intensity"});
    info_.has_intensity = map_.intensity != VertexMap::kNone;
    if (info_.has_intensity) {
      collector_.Configure(false, IntensityRangeOf(vertex.properties[map_.intensity].type));
    }
    map_.rgb = {FindScalar(vertex, {"red"}), FindScalar(vertex, {"green"}),
                FindScalar(vertex, {"blue"})};
    MapColor();
  }

  void MapColor() {
    for (const std::size_t i : map_.rgb) {
      if (i == VertexMap::kNone) return;
    }
    const ScalarType type = Vertex().properties[map_.rgb[0]].type;
    info_.has_rgb = true;
    if (type == ScalarType::kUint8) {
      color_scale_ = ColorScale::k8Bit;
    } else if (type == ScalarType::kUint16) {
      color_scale_ = ColorScale::k16Bit;
    } else if (IsFloat(type)) {
      color_scale_ = ColorScale::kUnit;
    } else {
      info_.has_rgb = false;
    }
    for (const std::size_t i : map_.rgb) {
      if (Vertex().properties[i].type != type) info_.has_rgb = false;
    }
    if (!info_.has_rgb) {
      info_.notes.emplace_back("colours are not uchar, ushort or float throughout: skipped");
    }
    info_.rgb_16_bit = info_.has_rgb && color_scale_ != ColorScale::k8Bit;
  }

  void Add(PointChunk& chunk) {
    const auto value = [&](std::size_t i) { return values_[i]; };
    if (!collector_.AddPoint(value(map_.xyz[0]), value(map_.xyz[1]), value(map_.xyz[2]), chunk)) {
      return;
    }
    if (info_.has_intensity) collector_.AddIntensity(value(map_.intensity), chunk);
    if (!info_.has_rgb) return;
    chunk.rgb.push_back({ScaleColor(value(map_.rgb[0]), color_scale_),
                         ScaleColor(value(map_.rgb[1]), color_scale_),
                         ScaleColor(value(map_.rgb[2]), color_scale_)});
  }

  ByteSource source_;
  LineReader lines_;
  PlyHeader header_;
  RecordReader records_;
  std::size_t vertex_index_ = 0;
  VertexMap map_;
  ColorScale color_scale_ = ColorScale::k8Bit;
  ScanInfo info_;
  PointCollector collector_;
  std::vector<double> values_;
  std::uint64_t done_ = 0;
};

}  // namespace

std::unique_ptr<ScanReader> OpenPly(const std::string& path) {
  return std::make_unique<PlyReader>(path);
}

}  // namespace backsight
