#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "io/picture_record.h"
#include "io/run_records.h"

namespace backsight {

/// What report.json holds, and all that report.html is made from.
struct ReportDocument {
  RunRecord run;  ///< its links are those that were tried
  /// Pairs never tried, by reason; there may be some hundred thousand, and links.csv lists them.
  std::vector<std::pair<std::string, std::uint64_t>> skipped_pairs;
  std::vector<PictureRecord> pictures;
};

/// Takes the skipped links out of the run and counts them.
ReportDocument MakeReportDocument(RunRecord run, std::vector<PictureRecord> pictures);

/// The version of report.json; docs/schema/report.schema.json describes it.
inline constexpr int kReportVersion = 4;

/// The text of report.json. A non-finite number is an InternalError that names its place.
std::string ReportJson(const ReportDocument& document);

/// Reads the text of a report.json; `path` names it in errors. Throws InputError with the place,
/// what was found and what was expected where the text is damaged, of another version, or no report
/// at all. Keys that it does not know are ignored.
ReportDocument ParseReport(const std::string& text, const std::string& path);

}  // namespace backsight
