#pragma once

#include <string>

#include "io/run_records.h"
#include "io/survey_project.h"

namespace backsight {

/// The record of a run whose clouds and maps are still to be written, for the reports that go
/// before them: verdict, exit code and a warning say that they are not finished, so that nobody
/// takes the report of a run that was cut short for the final one. Unchanged where nothing is to be
/// written: the project wants nothing, or no stations are connected.
RunRecord WithUnfinishedClouds(RunRecord run, const SurveyProject& project,
                               const std::string& out_directory);

}  // namespace backsight
