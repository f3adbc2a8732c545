#pragma once

#include <filesystem>
#include <string>

#include "io/report_document.h"

namespace backsight {

/// A run with everything that a report can show: two components, an unplaced and an unreadable
/// station, accepted, rejected and failed links, repairs, gates, warnings. Station ids S1, S2, ...
RunRecord SampleRun();

/// The same as report.json holds it, with a picture of every kind.
ReportDocument SampleReport();
ReportDocument SampleReport(RunRecord run);

/// A run of so many stations on a winding way, each linked with those near it, all placed.
RunRecord LargeRun(int stations);

/// A folder of its own for a test, removed with everything in it at the end.
class TestFolder {
 public:
  TestFolder();
  ~TestFolder();
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  /// Writes a file and returns its path.
  std::string Write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace backsight
