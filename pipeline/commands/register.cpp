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

void PrintQuality(int correspondences, int consensus, int consensus_null) {
  fmt::print("correspondences: {}\nconsensus: {} key points (chance alone: {})\n", correspondences,
             consensus, consensus_null);
}

int RegisterPoints(const Correspondences& correspondences, const SurveyOptions& options,
                   const ExecutionContext& context) {
  CoarseInput input;
  input.correspondences = correspondences;
  input.resolution_m = options.ingest.resolution_m;
  const CoarseResult coarse = RegisterCoarse(input, options.coarse, context);
  const int consensus = coarse.candidates.empty() ? 0 : coarse.candidates.front().consensus;
  PrintQuality(static_cast<int>(correspondences.size()), consensus, coarse.consensus_null);
  if (coarse.candidates.empty()) {
    fmt::print("status: rejected\nreason: not_registered\n");
    return kPartial;
  }
  PrintTransform(coarse.candidates.front().target_from_source);
  const bool significant = IsSignificant(consensus, coarse.consensus_null, options.verification);
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
  const PairCandidate* best = pair.best();
  PrintQuality(pair.correspondences, best != nullptr ? best->coarse.consensus : 0,
               pair.consensus_null);
  if (best != nullptr) {
    PrintTransform(stations[0].model.StationFromInstrument() * best->fine.target_from_source *
                   stations[1].model.StationFromInstrument().Inverse());
    fmt::print(
        "overlap: {:.3f}\nconflict: {:.3f}\nplanes: {}\nrms_m: {:.5f}\n"
        "weakest_sigma_m: {:.5f}\nrivals: {}\n",
        best->verification.overlap, best->verification.worst_conflict(), best->fine.planes,
        best->fine.rms_m, best->fine.weakest_sigma_m, pair.candidates.size() - 1);
  }
  fmt::print("status: {}\n", ToString(pair.verdict()));
  if (!pair.accepted()) fmt::print("reason: {}\n", ToString(pair.reason()));
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
