#include "io/scan_reader.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "io/byte_source.h"
#include "io/e57/e57_reader.h"
#include "io/las_reader.h"
#include "io/pcd_reader.h"
#include "io/ply_reader.h"
#include "io/pts_reader.h"
#include "io/ptx_reader.h"
#include "io/text_fields.h"
#include "io/xyz_reader.h"

namespace backsight {
namespace {

constexpr std::size_t kHeadBytes = 65536;
constexpr const char* kReadable = "E57, LAS, PCD, PLY, PTX, PTS or text (.xyz .txt .asc .csv)";

enum class Format { kE57, kLas, kPcd, kPly, kPts, kPtx, kXyz };

std::string ExtensionOf(const std::string& path) {
  const std::size_t dot = path.find_last_of("./");
  return dot == std::string::npos || path[dot] == '/' ? "" : ToLower(path.substr(dot + 1));
}

[[noreturn]] void RefuseFormat(const std::string& path, std::string_view name,
                               std::string_view remedy) {
  throw InputError(
      {path, fmt::format("{} file, which cannot be read", name), kReadable, std::string(remedy)});
}

/// Throws for formats that are known but not readable, with the way out.
void RefuseKnown(const std::string& path, std::string_view head) {
  if (head.starts_with("LASF")) {
    // Byte 104 is the point format, with an upper bit set where the points are LAZ compressed;
    // COPC is LAZ whose first variable length record, right behind the header, is named "copc".
    const bool packed = head.size() > 104 && (static_cast<unsigned char>(head[104]) & 0xC0U) != 0;
    const bool copc = head.size() > 381 && head.substr(377, 4) == "copc";
    if (packed || copc) {
      RefuseFormat(path, copc ? "COPC" : "LAZ",
                   "unpack it with 'laszip -i IN.laz -o OUT.las', 'pdal translate IN.laz OUT.las' "
                   "or CloudCompare");
    }
  }
  constexpr std::string_view kZip("PK\x03\x04", 4);
  constexpr std::string_view kGzip("\x1f\x8b", 2);
  if (head.starts_with(kZip) || head.starts_with(kGzip)) {
    RefuseFormat(path, "a compressed (zip or gzip)", "unpack it first");
  }
}

/// The first lines of `head` that are neither blank nor comments; the last may be cut off.
std::vector<std::string_view> FirstLines(std::string_view head, std::size_t n) {
  std::vector<std::string_view> lines;
  while (!head.empty() && lines.size() < n) {
    const std::size_t end = head.find('\n');
    const std::string_view line = Trim(head.substr(0, end));
    if (!line.empty() && line.front() != '#') lines.push_back(line);
    head.remove_prefix(end == std::string_view::npos ? head.size() : end + 1);
  }
  return lines;
}

/// How many numbers the line holds, or nothing if it holds anything else.
std::optional<std::size_t> CountNumbers(std::string_view line) {
  std::array<std::string_view, 16> words;
  const char separator = line.find(';') != std::string_view::npos   ? ';'
                         : line.find(',') != std::string_view::npos ? ','
                                                                    : ' ';
  const std::size_t count = SplitFields(line, separator, words);
  for (std::size_t i = 0; i < std::min(count, words.size()); ++i) {
    if (!ParseNumber(words[i])) return std::nullopt;
  }
  return count;
}

bool LooksLikePtx(const std::vector<std::string_view>& lines) {
  return lines.size() >= 3 && ParseCount(lines[0]) && ParseCount(lines[1]) &&
         CountNumbers(lines[2]) == 3U;
}

/// A line with the number of points, possibly behind a line of names, and points.
bool LooksLikePts(const std::vector<std::string_view>& lines) {
  for (std::size_t i = 0; i < 2 && i + 1 < lines.size(); ++i) {
    if (ParseCount(lines[i])) return CountNumbers(lines[i + 1]).value_or(0) >= 3;
  }
  return false;
}

bool LooksLikeXyz(const std::vector<std::string_view>& lines) {
  for (const std::string_view line : lines) {
    if (CountNumbers(line).value_or(0) >= 3) return true;
  }
  return false;
}

std::optional<Format> FormatByContent(std::string_view head) {
  if (head.starts_with("ASTM-E57")) return Format::kE57;
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return Format::kPly;
  if (head.starts_with("# .PCD")) return Format::kPcd;
  if (head.starts_with("LASF")) return Format::kLas;
  const std::vector<std::string_view> lines = FirstLines(head, 5);
  if (lines.empty()) return std::nullopt;
  for (const std::string_view key : {"VERSION ", "FIELDS ", "COLUMNS "}) {
    if (lines[0].starts_with(key)) return Format::kPcd;
  }
  if (LooksLikePtx(lines)) return Format::kPtx;
  if (LooksLikePts(lines)) return Format::kPts;
  return std::nullopt;
}

std::optional<Format> FormatByExtension(const std::string& extension) {
  if (extension == "pcd") return Format::kPcd;
  if (extension == "ply") return Format::kPly;
  if (extension == "ptx") return Format::kPtx;
  for (const char* text : {"xyz", "txt", "asc", "csv", "pts"}) {
    if (extension == text) return Format::kXyz;
  }
  return std::nullopt;
}

Format FindFormat(const std::string& path) {
  ByteSource source(path);
  const std::string_view head = source.Peek(kHeadBytes);
  RefuseKnown(path, head);
  if (const auto format = FormatByContent(head)) return *format;
  const std::string extension = ExtensionOf(path);
  const std::vector<std::string_view> lines = FirstLines(head, 5);
  // PTS files without a count exist; they are read as XYZ.
  if (extension == "pts" && !lines.empty() && ParseCount(lines[0])) return Format::kPts;
  if (const auto format = FormatByExtension(extension)) return *format;
  for (const char* refused : {"e57", "las", "laz"}) {
    if (extension != refused) continue;
    throw InputError({path, fmt::format("named .{}, but its content is not {}", refused, refused),
                      kReadable, "the file is damaged or misnamed"});
  }
  if (LooksLikeXyz(lines)) return Format::kXyz;
  throw InputError({path, fmt::format("unknown format, starts with {}", Quoted(head)), kReadable,
                    "convert it to one of these"});
}

bool TakesColumns(Format format) { return format == Format::kXyz || format == Format::kPts; }

std::unique_ptr<ScanReader> OpenSingle(const std::string& path, Format format, int scan_index,
                                       const TextColumns& columns) {
  if (scan_index != 0) {
    throw InputError({path, fmt::format("no scan with index {}", scan_index),
                      "scan_index 0: the file holds one scan", "correct scan_index"});
  }
  if (format == Format::kLas) return OpenLas(path);
  if (format == Format::kPcd) return OpenPcd(path);
  return format == Format::kPly ? OpenPly(path) : OpenXyz(path, columns);
}

}  // namespace

bool TakesColumns(const std::string& path) { return TakesColumns(FindFormat(path)); }

std::unique_ptr<ScanReader> OpenScan(const std::string& path, int scan_index,
                                     const TextColumns& columns,
                                     const std::function<void()>& between) {
  const Format format = FindFormat(path);
  if (!columns.empty() && !TakesColumns(format)) {
    throw InputError({path, "columns are given, but this format says itself what it holds",
                      "columns only for text scans (XYZ, PTS)", "leave columns out"});
  }
  if (format == Format::kE57) return OpenE57(path, scan_index);
  if (format == Format::kPtx) return OpenPtx(path, scan_index, between);
  if (format == Format::kPts) return OpenPts(path, scan_index, columns);
  return OpenSingle(path, format, scan_index, columns);
}

}  // namespace backsight
