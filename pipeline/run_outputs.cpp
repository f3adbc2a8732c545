#include "pipeline/run_outputs.h"

#include <cstdint>
#include <filesystem>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/report_document.h"
#include "io/report_html.h"
#include "io/run_json.h"
#include "io/run_tables.h"
#include "io/text_file.h"
#include "pipeline/report_paths.h"

namespace backsight {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t kMostBytes = std::uintmax_t{2} << 30U;  // of a report.json

}  // namespace

void MakeDirectories(const std::string& path) {
  std::error_code error;
  if (!path.empty()) fs::create_directories(path, error);
  if (error) {
    throw InputError({path, "cannot be made: " + error.message(), "a directory to write into", ""});
  }
}

void WriteReports(const RunRecord& real, const std::vector<PictureRecord>& pictures,
                  const std::string& project_path, const std::string& out_directory) {
  const RunRecord run = WithProjectPaths(real, project_path);
  const fs::path out(out_directory);
  WriteTextFile((out / "poses.csv").string(), PosesCsv(run.poses));
  WriteTextFile((out / "poses.json").string(), PosesJson(run.poses));
  WriteTextFile((out / "links.csv").string(), LinksCsv(run.links));
  WriteTextFile((out / "report.json").string(), ReportJson(MakeReportDocument(run, pictures)));
  RewriteReport(out_directory);
}

std::string RewriteReport(const std::string& out_directory) {
  const std::string json = (fs::path(out_directory) / "report.json").string();
  std::error_code error;
  if (!fs::exists(json, error)) {
    throw InputError({json, "no such file", "the report.json of an earlier run",
                      "`backsight run` writes it; --out names another folder of results"});
  }
  const std::string html = (fs::path(out_directory) / "report.html").string();
  WriteTextFile(html, ReportHtml(ParseReport(ReadTextFile(json, kMostBytes), json)));
  return html;
}

}  // namespace backsight
