#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/execution.h"
#include "io/artifact_store.h"
#include "io/geodetic_frame.h"
#include "io/run_records.h"
#include "io/survey_project.h"
#include "pipeline/network_pipeline.h"
#include "pipeline/run_stages.h"
#include "pipeline/survey_options.h"

namespace backsight {

/// The exit codes of docs/conventions.md that a run can end with.
enum ExitCode : int {
  kComplete = 0,
  kInternalFailure = 1,
  kBadInput = 2,
  kPartial = 3,
  kGateFailed = 4,
  kNoUsableInput = 5,
  kNoRoom = 6,
  kTryAgain = 75,
  kInterrupted = 130,
  kTerminated = 143,
};

/// Of every random choice a run makes.
inline constexpr std::uint64_t kRunSeed = 0;

struct SurveyRun {
  RunRecord record;
  std::vector<std::string> scan_fingerprints;  ///< by station; empty where unreadable
  std::vector<StageTime> times;
};

/// The whole method, from scan files to outputs in `out_directory`: loads the stations, registers
/// all pairs, fuses them to a network, ties it to control, merges the clouds and writes tables and
/// reports. `frame`: MakeControlFrame of the project. What the store holds is not done again.
/// Ends after the stage `last`: after stations and pairs only verdict and exit code of the record
/// are set; after the network tables and reports are written, but no clouds.
SurveyRun RunSurvey(const SurveyProject& project, const SurveyOptions& options,
                    std::shared_ptr<const GeodeticFrame> frame, const std::string& out_directory,
                    const ExecutionContext& context, const ArtifactStore& store,
                    Stage last = Stage::kOutputs);

}  // namespace backsight
