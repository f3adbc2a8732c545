#include "io/ply_header.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <span>

#include "io/text_fields.h"

namespace backsight {
namespace {

constexpr std::size_t kMaxProperties = 4096;
constexpr const char* kRemedy = "the PLY header is damaged: export the file again";

using Words = std::span<const std::string_view>;

std::optional<ScalarType> TypeOf(std::string_view name) {
  struct Known {
    std::string_view name;
    ScalarType type;
  };
  static constexpr std::array<Known, 18> kKnown{{{"char", ScalarType::kInt8},
                                                 {"int8", ScalarType::kInt8},
                                                 {"uchar", ScalarType::kUint8},
                                                 {"uint8", ScalarType::kUint8},
                                                 {"short", ScalarType::kInt16},
                                                 {"int16", ScalarType::kInt16},
                                                 {"ushort", ScalarType::kUint16},
                                                 {"uint16", ScalarType::kUint16},
                                                 {"int", ScalarType::kInt32},
                                                 {"int32", ScalarType::kInt32},
                                                 {"uint", ScalarType::kUint32},
                                                 {"uint32", ScalarType::kUint32},
                                                 {"float", ScalarType::kFloat32},
                                                 {"float32", ScalarType::kFloat32},
                                                 {"double", ScalarType::kFloat64},
                                                 {"float64", ScalarType::kFloat64},
                                                 {"int64", ScalarType::kInt64},
                                                 {"uint64", ScalarType::kUint64}}};
  for (const Known& known : kKnown) {
    if (known.name == name) return known.type;
  }
  return std::nullopt;
}

class HeaderParser {
 public:
  explicit HeaderParser(LineReader& lines) : lines_(lines) {}

  PlyHeader Parse() {
    if (const std::string_view line = lines_.Require("ply"); Trim(line) != "ply") {
      throw lines_.Error(Quoted(line), "ply", kRemedy);
    }
    std::array<std::string_view, 6> words;
    while (true) {
      const std::string_view line = lines_.Require("a PLY header line (up to end_header)");
      const std::size_t count = SplitFields(line, ' ', words);
      if (count == 0 || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (!ParseLine(Words(words.data(), std::min(count, words.size())))) {
        throw lines_.Error(Quoted(line),
                           "'format KIND 1.0', 'element NAME COUNT', 'property TYPE NAME' or "
                           "'property list TYPE TYPE NAME'",
                           kRemedy);
      }
    }
    if (!has_format_) throw lines_.Error("no format line", "'format KIND 1.0'", kRemedy);
    return std::move(header_);
  }

 private:
  bool ParseLine(Words words) {
    if (words[0] == "format" && words.size() == 3) return ParseFormat(words[1], words[2]);
    if (words[0] == "element" && words.size() == 3) return ParseElement(words[1], words[2]);
    if (words[0] != "property" || header_.elements.empty()) return false;
    PlyProperty property;
    std::optional<ScalarType> count_type = ScalarType::kUint8;
    std::optional<ScalarType> type;
    if (words.size() == 5 && words[1] == "list") {
      property.is_list = true;
      count_type = TypeOf(words[2]);
      type = TypeOf(words[3]);
      property.name = ToLower(words[4]);
    } else if (words.size() == 3) {
      type = TypeOf(words[1]);
      property.name = ToLower(words[2]);
    }
    if (!type || !count_type || IsFloat(*count_type)) return false;
    property.type = *type;
    property.count_type = *count_type;
    return AddProperty(std::move(property));
  }

  bool ParseFormat(std::string_view kind, std::string_view version) {
    has_format_ = true;
    if (version != "1.0") return false;
    if (kind == "ascii") {
      header_.encoding = PlyEncoding::kAscii;
    } else if (kind == "binary_little_endian") {
      header_.encoding = PlyEncoding::kLittleEndian;
    } else if (kind == "binary_big_endian") {
      header_.encoding = PlyEncoding::kBigEndian;
    } else {
      return false;
    }
    return true;
  }

  bool ParseElement(std::string_view name, std::string_view count) {
    const std::optional<std::uint64_t> number = ParseCount(count);
    if (!number) return false;
    PlyElement element;
    element.name = ToLower(name);
    element.count = *number;
    header_.elements.push_back(std::move(element));
    return true;
  }

  bool AddProperty(PlyProperty property) {
    PlyElement& element = header_.elements.back();
    if (element.properties.size() == kMaxProperties) {
      throw lines_.Error("too many properties", fmt::format("<= {}", kMaxProperties), kRemedy);
    }
    property.offset = element.record_bytes;
    element.record_bytes += SizeOf(property.type);
    element.has_list = element.has_list || property.is_list;
    element.properties.push_back(std::move(property));
    return true;
  }

  LineReader& lines_;
  PlyHeader header_;
  bool has_format_ = false;
};

}  // namespace

PlyHeader ReadPlyHeader(LineReader& lines) { return HeaderParser(lines).Parse(); }

}  // namespace backsight
