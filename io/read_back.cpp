#include "io/read_back.h"

#include <fmt/format.h>

#include "core/error.h"

namespace backsight {
namespace {

CloudContent ReadContent(ScanReader& scan, const std::function<void()>& between) {
  CloudContent content;
  PointChunk chunk;
  while (scan.Next(chunk)) {
    if (between) between();
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      content.AddPoint({chunk.x[i], chunk.y[i], chunk.z[i]});
    }
  }
  content.records = scan.tally().records;
  content.crs = scan.info().crs;
  return content;
}

std::string BoundsText(const CloudContent& content) {
  return fmt::format("points from ({}, {}, {}) to ({}, {}, {})", content.low.x(), content.low.y(),
                     content.low.z(), content.high.x(), content.high.y(), content.high.z());
}

}  // namespace

void RequireWritten(const std::string& path, ScanReader& scan, const CloudContent& written,
                    const std::function<void()>& between) {
  const CloudContent read = ReadContent(scan, between);
  const auto require = [&](bool same, const std::string& found, const std::string& expected) {
    if (same) return;
    throw InputError({path, found + " when it is read again", expected + ", as written",
                      "write the file again; check the disk if this repeats"});
  };
  require(read.records == written.records, fmt::format("{} records", read.records),
          fmt::format("{}", written.records));
  require(read.low == written.low && read.high == written.high, BoundsText(read),
          BoundsText(written));
  require(read.crs == written.crs, fmt::format("the reference system '{}'", read.crs),
          fmt::format("'{}'", written.crs));
}

}  // namespace backsight
