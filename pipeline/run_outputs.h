#pragma once

#include <string>
#include <vector>

#include "io/report_html.h"
#include "io/run_records.h"

namespace backsight {

/// Writes poses.csv, poses.json, links.csv, report.json and report.html.
void WriteReports(const RunRecord& run, const std::vector<ReportPicture>& pictures,
                  const std::string& out_directory);

/// Makes the directory and its parents. Throws InputError if that is impossible.
void MakeDirectories(const std::string& path);

}  // namespace backsight
