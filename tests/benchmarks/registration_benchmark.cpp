#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <map>
#include <optional>

#include "graph/correspondence_graph.h"
#include "stages/coarse_registration.h"
#include "stages/matching.h"
#include "stages/surface_choice.h"
#include "stages/surface_refinement.h"
#include "tests/benchmarks/facade_pairs.h"
#include "tests/benchmarks/pcl_registration.h"
#include "tests/support/synthetic_correspondences.h"

// The steps of pair registration on the pairs of ETH Facade ($BACKSIGHT_DATA/eth_facade) and on
// synthetic rows, beside PCL. Times over pairs are medians: iterations go round the pairs. The
// argument is the number of threads, 0 all.

namespace backsight {
namespace {

/// With what a station's pairs share.
FineInput FineInputOf(const FacadePair& p, const RigidTransform& motion,
                      const Matrix6d& information) {
  FineInput input{
      p.source->surface(), p.target->surface(), *p.target->index, motion, information, {}};
  input.target_planes = p.target_planes.get();
  input.source_surfaces = &p.source->prepared.Surfaces(p.source->surface());
  return input;
}

/// From correspondences to the refined motion: RGN, RGE, GNC and FR.
FineResult RowsToMotion(const FacadePair& p, const ExecutionContext& context) {
  const auto hypotheses = Hypotheses(Reliable(p.rows, context), context);
  if (hypotheses.empty()) return {};
  const RigidTransform motion =
      RefineOnInliers(p.rows, hypotheses[0].target_from_source, 3.0 * kResolution);
  const GncWelschResult gnc = Estimate(Inliers(p.rows, motion), motion);
  return RefinePair(FineInputOf(p, gnc.target_from_source, gnc.information), {}, context);
}

void BM_Rgn(benchmark::State& state) {
  const ExecutionContext context(static_cast<int>(state.range(0)));
  OverPairs(state, [&](const FacadePair& p) {
    benchmark::DoNotOptimize(SelectReliableNodes(p.rows, {.resolution_m = kResolution}, context));
  });
}

void BM_Rge(benchmark::State& state) {
  const ExecutionContext context(static_cast<int>(state.range(0)));
  OverPairs(state, [&](const FacadePair& p) {
    benchmark::DoNotOptimize(Hypotheses(p.reliable, context));
  });
}

void BM_Gnc(benchmark::State& state) {
  OverPairs(state,
            [](const FacadePair& p) { benchmark::DoNotOptimize(Estimate(p.inliers, p.coarse)); });
}

void BM_Fine(benchmark::State& state) {
  const ExecutionContext context(1);
  OverPairs(state, [&](const FacadePair& p) {
    benchmark::DoNotOptimize(
        RefinePair(FineInputOf(p, p.coarse, Matrix6d::Identity() * 1e4), {}, context));
  });
}

void BM_FineWithoutSurfaces(benchmark::State& state) {
  const ExecutionContext context(1);
  FineOptions options;
  options.surfaces = false;
  OverPairs(state, [&](const FacadePair& p) {
    benchmark::DoNotOptimize(
        RefinePair(FineInputOf(p, p.coarse, Matrix6d::Identity() * 1e4), options, context));
  });
}

/// What the pairs of a station share, once for all of them.
void BM_FineOncePerStation(benchmark::State& state) {
  OverPairs(state, [](const FacadePair& p) {
    benchmark::DoNotOptimize(MakePlaneTree(p.target->surface(), {}));
    benchmark::DoNotOptimize(ChooseSurfaces(p.target->surface().normals, kRefinedSurfaces));
  });
}

std::vector<Eigen::Vector3d> MeansOf(const Station& station) {
  const VoxelPoints& means = station.model.leaves.means();
  return {means.begin(), means.end()};
}

void BM_GicpPcl(benchmark::State& state) {
  OverPairs(state, [](const FacadePair& p) {
    benchmark::DoNotOptimize(
        PclGicp(MeansOf(*p.source), MeansOf(*p.target), p.coarse, 2.0 * kResolution));
  });
}

void BM_PointToPlanePcl(benchmark::State& state) {
  OverPairs(state, [](const FacadePair& p) {
    benchmark::DoNotOptimize(PclPointToPlane(MeansOf(*p.source), MeansOf(*p.target),
                                             p.target->features.normals, p.coarse,
                                             2.0 * kResolution));
  });
}

void BM_RowsToMotion(benchmark::State& state) {
  const ExecutionContext context(static_cast<int>(state.range(0)));
  OverPairs(state,
            [&](const FacadePair& p) { benchmark::DoNotOptimize(RowsToMotion(p, context)); });
  ReportErrors([&](const FacadePair& p) { return RowsToMotion(p, context).target_from_source; },
               &state);
}

void BM_PrerejectivePcl(benchmark::State& state) {
  OverPairs(state, [](const FacadePair& p) {
    benchmark::DoNotOptimize(PclPrerejective(KeypointPositions(p.source->model, p.source->features),
                                             p.source->features.descriptors,
                                             KeypointPositions(p.target->model, p.target->features),
                                             p.target->features.descriptors, kResolution));
  });
}

void BM_Verification(benchmark::State& state) {
  FineResult fine;
  fine.status = FineResult::Status::kRefined;
  OverPairs(state, [&](const FacadePair& p) {
    fine.target_from_source = p.coarse;
    benchmark::DoNotOptimize(
        VerifyPair({p.source->surface(), p.target->surface(), *p.source->index, *p.target->index,
                    p.coarse, Matrix6d::Identity(), 100, 4, fine, std::nullopt},
                   {}));
  });
}

void BM_WholePair(benchmark::State& state) {
  const ExecutionContext context(static_cast<int>(state.range(0)));
  OverPairs(state, [&](const FacadePair& p) {
    Pair pair = p.pair;
    RegisterPair(TheFacade().stations, {}, context, &pair);
    benchmark::DoNotOptimize(pair);
  });
}

const SyntheticMatches& Rows22k() {
  static const SyntheticMatches matches =
      MakeMatches(1, {.inliers = 400, .outliers = 21600, .noise_m = 0.03, .extent_m = 30.0});
  return matches;
}

void BM_Rgn22k(benchmark::State& state) {
  const ExecutionContext context(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(Reliable(Rows22k().c, context));
}

void BM_Rge22k(benchmark::State& state) {
  const ExecutionContext context(static_cast<int>(state.range(0)));
  const Correspondences reliable = Reliable(Rows22k().c, context);
  for (auto _ : state) benchmark::DoNotOptimize(Hypotheses(reliable, context));
}

/// RGN, RGE and GNC; there are no clouds to refine on.
void BM_RowsToMotion22k(benchmark::State& state) {
  const ExecutionContext context(static_cast<int>(state.range(0)));
  const Correspondences& c = Rows22k().c;
  GncWelschResult gnc;
  for (auto _ : state) {
    const auto hypotheses = Hypotheses(Reliable(c, context), context);
    const RigidTransform motion =
        RefineOnInliers(c, hypotheses.at(0).target_from_source, 3.0 * kResolution);
    gnc = Estimate(Inliers(c, motion), motion);
  }
  state.counters["error_mm"] =
      1e3 * (gnc.target_from_source.translation - Rows22k().target_from_source.translation).norm();
}

BENCHMARK(BM_Rgn)->Arg(1)->Arg(0)->UseManualTime()->Iterations(84)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Rge)->Arg(1)->Arg(0)->UseManualTime()->Iterations(84)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Gnc)->UseManualTime()->Iterations(84)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Fine)->UseManualTime()->Iterations(84)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_FineWithoutSurfaces)->UseManualTime()->Iterations(84)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_FineOncePerStation)->UseManualTime()->Iterations(42)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_GicpPcl)->UseManualTime()->Iterations(5)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_PointToPlanePcl)->UseManualTime()->Iterations(5)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_RowsToMotion)
    ->Arg(1)
    ->Arg(0)
    ->UseManualTime()
    ->Iterations(84)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(BM_PrerejectivePcl)->UseManualTime()->Iterations(5)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Verification)->UseManualTime()->Iterations(42)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_WholePair)
    ->Arg(1)
    ->Arg(0)
    ->UseManualTime()
    ->Iterations(21)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Rgn22k)->Arg(1)->Arg(0)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Rge22k)->Arg(1)->Arg(0)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(BM_RowsToMotion22k)->Arg(1)->Arg(0)->UseRealTime()->Unit(benchmark::kMillisecond);

/// Remembers the times, for the ratios at the end.
class RatioReporter : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      const std::string& name = run.run_name.function_name;
      if (!run.error_occurred) times_.try_emplace(name, run.GetAdjustedRealTime());
    }
  }
  void PrintRatios() const {
    const std::vector<std::pair<std::string, std::string>> peers = {
        {"BM_MatchingPcl", "BM_Matching"},
        {"BM_MatchingTogetherPcl", "BM_MatchingTogether"},
        {"BM_Matching8kPcl", "BM_Matching8k"},
        {"BM_PrerejectivePcl", "BM_RowsToMotion"},
        {"BM_GicpPcl", "BM_Fine"},
        {"BM_PointToPlanePcl", "BM_Fine"}};
    for (const auto& [theirs, ours] : peers) {
      if (!times_.contains(theirs) || !times_.contains(ours)) continue;
      fmt::print("{} / {}: {:.1f}\n", theirs, ours, times_.at(theirs) / times_.at(ours));
    }
  }

 private:
  std::map<std::string, double> times_;
};

}  // namespace
}  // namespace backsight

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  backsight::RatioReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.PrintRatios();
  return 0;
}
