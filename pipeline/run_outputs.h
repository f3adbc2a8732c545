#pragma once

#include <string>
#include <vector>

#include "core/execution.h"
#include "io/report_html.h"
#include "io/run_records.h"
#include "io/survey_project.h"
#include "pipeline/georeference_network.h"
#include "pipeline/network_pipeline.h"

namespace backsight {

/// Writes the merged clouds the project asks for (default: merged.las in `out_directory`), one file
/// per component of two or more stations; further components get "_component2" and so on in their
/// names, and a cloud that is split over several files "-1", "-2" (WrittenFiles). Nothing is
/// written for a network without links.
std::vector<OutputRecord> WriteMergedClouds(
    const SurveyProject& project, const IngestOptions& ingest, const std::vector<Station>& stations,
    const Network& network, const GeoreferencedNetwork& ground, const std::string& out_directory,
    const ExecutionContext& context);

/// Writes poses.csv, poses.json, links.csv, report.json and report.html.
void WriteReports(const RunRecord& run, const std::vector<ReportPicture>& pictures,
                  const std::string& out_directory);

/// Makes the directory and its parents. Throws InputError if that is impossible.
void MakeDirectories(const std::string& path);

}  // namespace backsight
