// Writes report.json and report.html of made-up runs: sample_report FOLDER makes FOLDER/sample,
// FOLDER/two (two stations) and FOLDER/large (200 stations).
#include <filesystem>
#include <fstream>
#include <string>

#include "io/report_html.h"
#include "tests/io/sample_run.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

void Write(const fs::path& folder, const ReportDocument& document) {
  fs::create_directories(folder);
  const std::string json = ReportJson(document);
  std::ofstream(folder / "report.json", std::ios::binary) << json;
  std::ofstream(folder / "report.html", std::ios::binary)
      << ReportHtml(ParseReport(json, "sample"));
}

RunRecord TwoStations() {
  RunRecord run = LargeRun(2);
  run.georeference.clear();
  run.distances.reset();
  run.warnings.clear();
  run.closures.clear();
  run.gates.clear();
  return run;
}

RunRecord WithLongNames() {
  RunRecord run = SampleRun();
  run.project_name = std::string(120, 'n') + " <name>";
  run.scans.front().path = std::string(200, 'p') + ".ptx";
  run.warnings.push_back(std::string(300, 'w'));
  return run;
}

}  // namespace
}  // namespace backsight

int main(int argc, char** argv) {
  using namespace backsight;
  if (argc != 2) return 2;
  const fs::path folder = argv[1];
  Write(folder / "sample", SampleReport(WithLongNames()));
  Write(folder / "two", MakeReportDocument(TwoStations(), {}));
  Write(folder / "large", SampleReport(LargeRun(200)));
  return 0;
}
