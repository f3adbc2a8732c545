#include "pipeline/run_outputs.h"

#include <filesystem>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/report_html.h"
#include "io/run_json.h"
#include "io/run_tables.h"

namespace backsight {

namespace fs = std::filesystem;

void MakeDirectories(const std::string& path) {
  std::error_code error;
  if (!path.empty()) fs::create_directories(path, error);
  if (error) {
    throw InputError({path, "cannot be made: " + error.message(), "a directory to write into", ""});
  }
}

void WriteReports(const RunRecord& run, const std::vector<ReportPicture>& pictures,
                  const std::string& out_directory) {
  const fs::path out(out_directory);
  WriteTextFile((out / "poses.csv").string(), PosesCsv(run.poses));
  WriteTextFile((out / "poses.json").string(), PosesJson(run.poses));
  WriteTextFile((out / "links.csv").string(), LinksCsv(run.links));
  WriteTextFile((out / "report.json").string(), ReportJson(run));
  WriteTextFile((out / "report.html").string(), ReportHtml(run, pictures));
}

}  // namespace backsight
