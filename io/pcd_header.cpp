#include "io/pcd_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "io/text_fields.h"

namespace backsight {
namespace {

constexpr std::size_t kMaxFields = 1024;
constexpr std::size_t kMaxRecordBytes = 65536;
constexpr const char* kRemedy = "the PCD header is damaged: export the file again";

using Words = std::span<const std::string_view>;

std::optional<ScalarType> TypeOf(char kind, std::size_t size) {
  struct Known {
    char kind;
    std::size_t size;
    ScalarType type;
  };
  static constexpr std::array<Known, 10> kKnown{{{'I', 1, ScalarType::kInt8},
                                                 {'U', 1, ScalarType::kUint8},
                                                 {'I', 2, ScalarType::kInt16},
                                                 {'U', 2, ScalarType::kUint16},
                                                 {'I', 4, ScalarType::kInt32},
                                                 {'U', 4, ScalarType::kUint32},
                                                 {'I', 8, ScalarType::kInt64},
                                                 {'U', 8, ScalarType::kUint64},
                                                 {'F', 4, ScalarType::kFloat32},
                                                 {'F', 8, ScalarType::kFloat64}}};
  for (const Known& known : kKnown) {
    if (known.kind == kind && known.size == size) return known.type;
  }
  return std::nullopt;
}

class HeaderParser {
 public:
  explicit HeaderParser(LineReader& lines) : lines_(lines) {}

  PcdHeader Parse() {
    std::array<std::string_view, kMaxFields + 1> words;
    while (true) {
      const std::string_view line = lines_.Require("a PCD header line (up to DATA)");
      const std::size_t count = SplitFields(line, ' ', words);
      if (count == 0 || words[0].starts_with('#')) continue;
      if (count > words.size()) {
        throw lines_.Error(fmt::format("{} words", count), fmt::format("<= {}", kMaxFields),
                           kRemedy);
      }
      const Words values(words.data() + 1, count - 1);
      if (words[0] == "DATA") {
        ParseData(values);
        break;
      }
      ParseLine(words[0], values);
    }
    LayOutFields();
    CountPoints();
    return std::move(header_);
  }

 private:
  void ParseLine(std::string_view key, Words values) {
    if (key == "VERSION") {
      ParseVersion(values);
    } else if (key == "FIELDS" || key == "COLUMNS") {
      names_.assign(values.begin(), values.end());
    } else if (key == "SIZE") {
      sizes_ = ParseCounts(values);
    } else if (key == "TYPE") {
      types_.assign(values.begin(), values.end());
    } else if (key == "COUNT") {
      counts_ = ParseCounts(values);
    } else if (key == "WIDTH") {
      header_.width = ParseOne(values);
      has_width_ = true;
    } else if (key == "HEIGHT") {
      header_.height = ParseOne(values);
    } else if (key == "POINTS") {
      points_ = ParseOne(values);
    } else if (key == "VIEWPOINT") {
      ParseViewpoint(values);
    } else {
      throw lines_.Error(
          Quoted(key),
          "one of VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, VIEWPOINT, POINTS, DATA",
          kRemedy);
    }
  }

  void ParseVersion(Words values) {
    const std::optional<double> version =
        values.size() == 1 ? ParseNumber(values[0]) : std::nullopt;
    if (!version || *version < 0.5 || *version > 0.7) {
      throw lines_.Error(values.empty() ? "no version" : "version " + Quoted(values[0]),
                         "0.5, 0.6 or 0.7", "save the file as PCD 0.7");
    }
  }

  std::vector<std::uint64_t> ParseCounts(Words values) {
    std::vector<std::uint64_t> counts;
    for (const std::string_view value : values) {
      const std::optional<std::uint64_t> count = ParseCount(value);
      if (!count || *count == 0 || *count > kMaxRecordBytes) {
        throw lines_.Error(Quoted(value), fmt::format("a number from 1 to {}", kMaxRecordBytes),
                           kRemedy);
      }
      counts.push_back(*count);
    }
    return counts;
  }

  std::uint64_t ParseOne(Words values) {
    const std::optional<std::uint64_t> count =
        values.size() == 1 ? ParseCount(values[0]) : std::nullopt;
    if (!count) {
      throw lines_.Error(values.empty() ? "no number" : Quoted(values[0]),
                         "one unsigned whole number", kRemedy);
    }
    return *count;
  }

  void ParseViewpoint(Words values) {
    std::array<double, 7> v{};
    bool good = values.size() == v.size();
    for (std::size_t i = 0; good && i < v.size(); ++i) {
      const std::optional<double> number = ParseNumber(values[i]);
      if (!number) throw lines_.Error(Quoted(values[i]), "a number", kRemedy);
      v[i] = *number;
      good = std::isfinite(v[i]);
    }
    const Eigen::Quaterniond rotation(v[3], v[4], v[5], v[6]);
    if (good && std::abs(rotation.norm() - 1.0) < 1e-3) {
      header_.viewpoint = RigidTransform::FromQuaternion(rotation.normalized(), {v[0], v[1], v[2]});
    } else {
      header_.viewpoint_unusable = true;
    }
  }

  void ParseData(Words values) {
    const std::string_view kind = values.size() == 1 ? values[0] : std::string_view();
    if (kind == "ascii") {
      header_.data = PcdData::kAscii;
    } else if (kind == "binary") {
      header_.data = PcdData::kBinary;
    } else if (kind == "binary_compressed") {
      header_.data = PcdData::kCompressed;
    } else {
      throw lines_.Error("DATA " + Quoted(kind), "ascii, binary or binary_compressed", kRemedy);
    }
  }

  void LayOutFields() {
    if (counts_.empty()) counts_.assign(names_.size(), 1);
    if (names_.empty() || sizes_.size() != names_.size() || types_.size() != names_.size() ||
        counts_.size() != names_.size()) {
      throw lines_.Error(fmt::format("{} FIELDS, {} SIZE, {} TYPE, {} COUNT entries", names_.size(),
                                     sizes_.size(), types_.size(), counts_.size()),
                         "one entry of each per field", kRemedy);
    }
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const std::optional<ScalarType> type =
          types_[i].size() == 1 ? TypeOf(types_[i][0], sizes_[i]) : std::nullopt;
      if (!type) {
        throw lines_.Error(fmt::format("field {} of TYPE {} and SIZE {}", Quoted(names_[i]),
                                       Quoted(types_[i]), sizes_[i]),
                           "I or U of 1, 2, 4, 8 bytes or F of 4, 8 bytes", kRemedy);
      }
      header_.fields.push_back(
          {names_[i], *type, counts_[i], header_.record_bytes, header_.columns});
      header_.record_bytes += SizeOf(*type) * counts_[i];
      header_.columns += counts_[i];
      if (header_.record_bytes > kMaxRecordBytes) {
        throw lines_.Error("records that are too long",
                           fmt::format("<= {} bytes per point", kMaxRecordBytes), kRemedy);
      }
    }
  }

  void CountPoints() {
    if (!points_ && !has_width_) {
      throw lines_.Error("neither POINTS nor WIDTH above this line", "the number of points",
                         kRemedy);
    }
    if (!has_width_) header_.width = *points_;
    const std::uint64_t width = header_.width;
    const std::uint64_t height = header_.height;
    const bool overflow = height != 0 && width > UINT64_MAX / height;
    if (overflow || (points_ && *points_ != width * height)) {
      throw lines_.Error(
          fmt::format("WIDTH {} and HEIGHT {} with POINTS {}", width, height, points_.value_or(0)),
          "POINTS = WIDTH * HEIGHT", kRemedy);
    }
    header_.points = width * height;
  }

  LineReader& lines_;
  PcdHeader header_;
  std::vector<std::string> names_;
  std::vector<std::string> types_;
  std::vector<std::uint64_t> sizes_;
  std::vector<std::uint64_t> counts_;
  std::optional<std::uint64_t> points_;
  bool has_width_ = false;
};

}  // namespace

const PcdField* PcdHeader::Find(std::string_view name) const {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const PcdField& field) {
    return field.name == name && field.count == 1;
  });
  return found == fields.end() ? nullptr : &*found;
}

PcdHeader ReadPcdHeader(LineReader& lines) { return HeaderParser(lines).Parse(); }

}  // namespace backsight
