#pragma once

#include <string>
#include <vector>

#include "io/picture_record.h"
#include "io/run_records.h"

namespace backsight {

/// Writes poses.csv, poses.json, links.csv, report.json and, from that, report.html. Paths in them
/// are those seen from the project file (WithProjectPaths).
void WriteReports(const RunRecord& run, const std::vector<PictureRecord>& pictures,
                  const std::string& project_path, const std::string& out_directory);

/// Writes report.html from the report.json beside it and returns its path. Throws InputError where
/// that is missing or damaged.
std::string RewriteReport(const std::string& out_directory);

/// Makes the directory and its parents. Throws InputError if that is impossible.
void MakeDirectories(const std::string& path);

}  // namespace backsight
