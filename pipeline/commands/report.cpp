#include <fmt/format.h>

#include "pipeline/commands/commands.h"
#include "pipeline/output_files.h"
#include "pipeline/run_outputs.h"
#include "pipeline/survey_pipeline.h"

namespace backsight {

int ReportCommand(const std::string& project, const std::string& out) {
  fmt::print("Report: {}\n", RewriteReport(out.empty() ? UsualOutDirectory(project) : out));
  return kComplete;
}

}  // namespace backsight
