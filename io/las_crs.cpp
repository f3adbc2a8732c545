#include "io/las_crs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>

#include "io/endian_bytes.h"
#include "io/geo_keys.h"
#include "io/las_header.h"
#include "io/text_fields.h"
#include "io/utf8.h"

namespace backsight {
namespace {

constexpr std::uint64_t kMaxCrsBytes = std::uint64_t{1} << 20U;
constexpr std::uint16_t kGeoKeyRecord = 34735;
constexpr std::uint16_t kGeoTextRecord = 34737;

// Byte offsets in the header of a record.
constexpr std::size_t kUser = 2;
constexpr std::size_t kUserBytes = 16;
constexpr std::size_t kRecordId = 18;
constexpr std::size_t kLength = 20;
constexpr std::size_t kDescription = 22;

/// Contents of the records that matter.
struct CrsRecords {
  std::string wkt;
  std::string geo_keys;
  std::string geo_text;

  std::string* Find(std::uint16_t id) {
    if (id == kLasWktRecord) return &wkt;
    if (id == kGeoKeyRecord) return &geo_keys;
    return id == kGeoTextRecord ? &geo_text : nullptr;
  }
};

/// A run of records, ordinary or extended ones.
struct RecordRun {
  std::string_view kind;
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
  std::uint32_t count = 0;
  std::size_t header_bytes = kLasRecordHeaderBytes;
};

void ReadRun(ByteSource& source, const RecordRun& run, CrsRecords& records,
             std::vector<std::string>& notes) {
  std::uint64_t at = run.begin;
  for (std::uint32_t i = 0; i < run.count; ++i) {
    std::array<char, kLasExtendedHeaderBytes> head{};
    const bool has_head = at <= run.end && run.end - at >= run.header_bytes;
    std::uint64_t length = 0;
    if (has_head) {
      source.Seek(at);
      source.Read(head.data(), run.header_bytes, "bytes of a record's header");
      length = run.header_bytes == kLasRecordHeaderBytes
                   ? LoadBytes<std::uint16_t>(head.data() + kLength)
                   : LoadBytes<std::uint64_t>(head.data() + kLength);
    }
    const std::uint64_t contents = at + run.header_bytes;
    if (!has_head || length > run.end - contents) {
      notes.push_back(
          fmt::format("{} record {} of {} at byte {} does not fit before byte {}: it "
                      "and those behind it are ignored",
                      run.kind, i + 1, run.count, at, run.end));
      return;
    }
    std::string_view user(head.data() + kUser, kUserBytes);
    user = user.substr(0, user.find('\0'));
    std::string* const to = user == kLasProjectionUser
                                ? records.Find(LoadBytes<std::uint16_t>(head.data() + kRecordId))
                                : nullptr;
    if (to != nullptr && to->empty() && length <= kMaxCrsBytes) {
      to->resize(static_cast<std::size_t>(length));
      source.Read(to->data(), to->size(), "bytes of a record");
    }
    at = contents + length;
  }
}

}  // namespace

std::string ReadLasCrs(ByteSource& source, const LasHeader& header,
                       std::vector<std::string>& notes) {
  CrsRecords records;
  ReadRun(source,
          {"variable length", header.header_bytes, header.point_offset, header.record_count,
           kLasRecordHeaderBytes},
          records, notes);
  ReadRun(source,
          {"extended variable length", header.extended_offset, source.size(), header.extended_count,
           kLasExtendedHeaderBytes},
          records, notes);
  const std::string wkt = CleanCrsText(records.wkt);
  const bool wants_wkt = (header.global_encoding & LasEncoding::kWkt) != 0;
  if (wkt.empty() || (!wants_wkt && !records.geo_keys.empty())) {
    // Cleaned last: the keys cut the text where they like, through characters too.
    const std::string_view text(records.geo_text);
    return CleanUtf8(DescribeGeoKeys(records.geo_keys, text.substr(0, text.find('\0'))));
  }
  return wkt;
}

std::vector<std::string> CrsUnitNotes(std::string_view crs) {
  const std::string lower = ToLower(crs);
  const auto names = [&](std::initializer_list<std::string_view> words) {
    return std::any_of(words.begin(), words.end(), [&](std::string_view word) {
      return lower.find(word) != std::string::npos;
    });
  };
  std::vector<std::string> notes;
  if (names({"geogcs", "geogcrs", "geographic"}) && !names({"projcs", "projcrs", "projected"})) {
    notes.emplace_back(
        "the stated reference system is geographic: x and y are degrees, but are read as metres");
  }
  if (names({"foot", "feet", "ftus"})) {
    notes.emplace_back(
        "the stated reference system has lengths in feet, but coordinates are read as metres");
  }
  return notes;
}

std::string CleanCrsText(std::string_view text) {
  return CleanUtf8(text.substr(0, text.find('\0')));
}

std::string EncodeWktRecord(std::string_view wkt) {
  BACKSIGHT_CHECK(wkt.size() < 65535, "a WKT too long for a variable length record");
  std::string record(kLasRecordHeaderBytes, '\0');
  std::copy(kLasProjectionUser.begin(), kLasProjectionUser.end(), record.data() + kUser);
  StoreBytes(record.data() + kRecordId, kLasWktRecord);
  StoreBytes(record.data() + kLength, static_cast<std::uint16_t>(wkt.size() + 1));
  constexpr std::string_view kText = "OGC coordinate system WKT";
  std::copy(kText.begin(), kText.end(), record.data() + kDescription);
  record += wkt;
  record += '\0';  // the standard wants a terminated string
  return record;
}

}  // namespace backsight
