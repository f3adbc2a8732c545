#include <fmt/format.h>

#include "pipeline/commands/commands.h"
#include "pipeline/run_outputs.h"
#include "pipeline/survey_pipeline.h"

namespace backsight {

int ReportCommand(const RunFolders& folders) {
  fmt::print("Report: {}\n", RewriteReport(folders.OutDirectory()));
  return kComplete;
}

}  // namespace backsight
