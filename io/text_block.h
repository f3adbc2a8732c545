#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "io/point_collector.h"
#include "io/scan_reader.h"

namespace backsight {

/// Lines of a text scan that become points together.
struct TextBlock : ScanBlock {
  std::string text;                ///< whole lines, with an LF behind each
  std::uint64_t lines_before = 0;  ///< lines of the file before these
  std::uint64_t first_record = 0;  ///< records of the scan before these
  std::size_t lines = 0;
  bool is_last = false;   ///< nothing of the scan follows
  PointCollector counts;  ///< of these records
};

/// The line that begins at `at`, without its end; `at` goes to the next one. `end`: of the text.
std::string_view TakeLine(const char*& at, const char* end);

/// Reads a line of exactly as many plain numbers (TakePlainNumber) as there are `values`, with
/// `separator` between (' ': any run of blanks and tabs), and goes to the next line. `is_skipped`,
/// as long as `values` or empty: which may hold anything; these become 0. False, and `at` means
/// nothing, for any other line, be it good or bad. An LF must follow.
bool TakePlainLine(const char*& at, char separator, std::span<const char> is_skipped,
                   std::span<double> values);

}  // namespace backsight
