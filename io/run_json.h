#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/run_records.h"

namespace backsight {

/// The texts of poses.json and manifest.json. Keys come in a fixed order and every file begins with
/// "schema_version": 1; a key may be added within a version, never change its meaning. Transforms
/// are {"translation_m": [x, y, z], "quaternion_wxyz": [w, x, y, z]}; what was never computed is
/// null. A non-finite number is an InternalError that names its place. Bytes that are not UTF-8 (in
/// paths) are replaced by U+FFFD. report.json, in the same manner: io/report_document.h.
std::string PosesJson(const std::vector<PoseRecord>& poses);
std::string ManifestJson(const ManifestRecord& manifest);

/// How the run ended that wrote the report.json in a folder.
struct LastRun {
  std::string verdict;
  int exit_code = 0;
};
/// Absent where there is no report, or a damaged one.
std::optional<LastRun> ReadLastRun(const std::string& out_directory);

/// The clouds that the run of a manifest wrote; none where the file is missing, damaged or older
/// than this list: what is not listed is nobody's to remove.
std::vector<WrittenCloud> ReadWrittenClouds(const std::string& manifest_path);

}  // namespace backsight
