#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "pipeline/commands/commands.h"
#include "pipeline/pair_pipeline.h"
#include "pipeline/point_lists.h"
#include "pipeline/survey_pipeline.h"
#include "pipeline/terminal_events.h"

namespace backsight {
namespace {

void PrintTransform(const RigidTransform& target_from_source) {
  const Eigen::Matrix4d m = target_from_source.Matrix();
  fmt::print("target_from_source:\n");
  for (int row = 0; row < 4; ++row) {
    fmt::print("{:.10f} {:.10f} {:.10f} {:.10f}\n", m(row, 0), m(row, 1), m(row, 2), m(row, 3));
  }
}

void PrintQuality(const Pair& pair) {
  fmt::print("correspondences: {}\nconsensus: {} key points (chance alone: {})\n",
             pair.correspondences, pair.coarse.consensus, pair.coarse.consensus_null);
}

bool IsSignificant(const CoarseResult& coarse, const VerificationOptions& options) {
  return coarse.consensus >=
         std::max(options.min_consensus, coarse.consensus_null + options.min_above_chance);
}

int RegisterPoints(const Correspondences& correspondences, const SurveyOptions& options,
                   const ExecutionContext& context) {
  CoarseInput input;
  input.correspondences = correspondences;
  input.resolution_m = options.ingest.resolution_m;
  Pair pair;
  pair.correspondences = static_cast<int>(correspondences.size());
  pair.coarse = RegisterCoarse(input, options.coarse, context);
  PrintQuality(pair);
  if (pair.coarse.status != CoarseResult::Status::kRegistered) {
    fmt::print("status: rejected\nreason: not_registered\n");
    return kPartial;
  }
  PrintTransform(pair.coarse.target_from_source);
  const bool significant = IsSignificant(pair.coarse, options.verification);
  fmt::print("status: {}\n", significant ? "accepted" : "rejected\nreason: not_significant");
  return significant ? kComplete : kPartial;
}

int RegisterScans(const std::string& source, const std::string& target,
                  const SurveyOptions& options, const ExecutionContext& context) {
  std::vector<StationSpec> specs(2);
  specs[0].id = "target";
  specs[0].scan = target;
  specs[1].id = "source";
  specs[1].scan = source;
  const std::vector<Station> stations = LoadStations(specs, options, context);
  for (const Station& station : stations) {
    if (!station.usable()) return kNoUsableInput;  // LoadStations has said why
  }
  Pair pair;
  pair.source = 1;
  pair.target = 0;
  RegisterPair(stations, options, context, &pair);
  if (!pair.fault.empty()) throw InternalError(pair.fault);
  PrintQuality(pair);
  if (pair.coarse.status == CoarseResult::Status::kRegistered) {
    PrintTransform(stations[0].model.StationFromInstrument() * pair.fine.target_from_source *
                   stations[1].model.StationFromInstrument().Inverse());
    fmt::print("overlap: {:.3f}\nplanes: {}\nrms_m: {:.5f}\nweakest_sigma_m: {:.5f}\n",
               pair.verification.overlap, pair.fine.planes, pair.fine.rms_m,
               pair.fine.weakest_sigma_m);
  }
  fmt::print("status: {}\n", pair.accepted() ? "accepted" : "rejected");
  if (!pair.accepted()) fmt::print("reason: {}\n", ToString(pair.verification.reason));
  return pair.accepted() ? kComplete : kPartial;
}

}  // namespace

int RegisterCommand(const RegisterArguments& arguments) {
  SurveyOptions options;
  if (arguments.resolution_m > 0.0) options.ingest.resolution_m = arguments.resolution_m;
  TerminalEvents events(TerminalEvents::Verbosity::kQuiet);
  const ExecutionContext context(arguments.threads, /*seed=*/0, &events);
  if (!arguments.correspondences.empty()) {
    return RegisterPoints(ReadCorrespondences(arguments.correspondences), options, context);
  }
  if (arguments.matched) {
    return RegisterPoints(ReadMatchedPoints(arguments.inputs[0], arguments.inputs[1]), options,
                          context);
  }
  return RegisterScans(arguments.inputs[0], arguments.inputs[1], options, context);
}

}  // namespace backsight
