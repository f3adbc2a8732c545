#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <map>
#include <memory>
#include <optional>

#include "core/random.h"
#include "graph/correspondence_graph.h"
#include "graph/edge_consensus.h"
#include "graph/gnc_welsch.h"
#include "graph/rigid_fit.h"
#include "pipeline/pair_pipeline.h"
#include "stages/coarse_registration.h"
#include "tests/benchmarks/pcl_registration.h"
#include "tests/support/synthetic_correspondences.h"

// The steps of pair registration on the pairs of ETH Facade ($BACKSIGHT_DATA/eth_facade) and on
// synthetic rows, beside PCL. Times over pairs are medians: iterations go round the pairs. The
// argument is the number of threads, 0 all.

namespace backsight {
namespace {

constexpr double kResolution = 0.1;

std::vector<Station> LoadFacade() {
  const char* data = std::getenv("BACKSIGHT_DATA");
  if (data == nullptr) return {};
  std::vector<StationSpec> specs;
  for (int s = 0; s < 7; ++s) {
    StationSpec spec;
    spec.id = fmt::format("s{}", s);
    spec.scan = fmt::format("{}/eth_facade/s{}.pcd", data, s);
    specs.push_back(spec);
  }
  std::vector<Station> stations = LoadStations(specs, {}, ExecutionContext(0));
  std::erase_if(stations, [](const Station& s) { return !s.usable(); });
  return stations;
}

/// A pair up to its coarse motion.
struct FacadePair {
  const Station* source = nullptr;
  const Station* target = nullptr;
  Pair pair;
  Correspondences rows;
  Correspondences reliable;
  RigidTransform coarse;
  Correspondences inliers;
};

Correspondences Reliable(const Correspondences& c, const ExecutionContext& context) {
  return c.Subset(SelectReliableNodes(c, {.resolution_m = kResolution}, context).rows);
}

std::vector<EdgeHypothesis> Hypotheses(const Correspondences& c, const ExecutionContext& context) {
  return FindEdgeHypotheses(c, {.resolution_m = kResolution, .edges_per_node = 2, .hypotheses = 40},
                            context);
}

Correspondences Inliers(const Correspondences& c, const RigidTransform& motion) {
  return c.Subset(RowsWithin(c, motion, 3.0 * kResolution));
}

GncWelschResult Estimate(const Correspondences& inliers, const RigidTransform& motion) {
  return EstimateGncWelsch(inliers, motion, {.resolution_m = kResolution});
}

struct Facade {
  std::vector<Station> stations = LoadFacade();
  std::vector<FacadePair> pairs;

  Facade() {
    const ExecutionContext context(0);
    for (const Pair& planned : PlanPairs(stations, {})) {
      FacadePair p;
      p.pair = planned;
      p.source = &stations[static_cast<std::size_t>(planned.source)];
      p.target = &stations[static_cast<std::size_t>(planned.target)];
      p.rows = MatchStations(p.source->model, p.source->features, p.target->model,
                             p.target->features, {});
      p.reliable = Reliable(p.rows, context);
      const auto hypotheses = Hypotheses(p.reliable, context);
      if (hypotheses.empty()) continue;
      p.coarse = RefineOnInliers(p.rows, hypotheses[0].target_from_source, 3.0 * kResolution);
      p.inliers = Inliers(p.rows, p.coarse);
      pairs.push_back(std::move(p));
    }
  }
};

const Facade& TheFacade() {
  static const Facade facade;
  return facade;
}

/// Medians over the pairs of what `body(pair)` takes; skips where the data is absent.
template <class Body>
void OverPairs(benchmark::State& state, Body body) {
  if (TheFacade().pairs.empty()) {
    state.SkipWithError("no BACKSIGHT_DATA/eth_facade");
    return;
  }
  std::vector<double> seconds;
  std::size_t next = 0;
  for (auto _ : state) {
    const FacadePair& pair = TheFacade().pairs[next++ % TheFacade().pairs.size()];
    const auto begin = std::chrono::steady_clock::now();
    body(pair);
    seconds.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    state.SetIterationTime(seconds.back());
  }
  std::sort(seconds.begin(), seconds.end());
  state.counters["median_ms"] = 1e3 * seconds[seconds.size() / 2];
  state.counters["max_ms"] = 1e3 * seconds.back();
}

FineResult Fine(const FacadePair& p, const RigidTransform& motion, const Matrix6d& information,
                const ExecutionContext& context) {
  return RefinePair(
      {p.source->surface(), p.target->surface(), *p.target->index, motion, information, {}}, {},
      context);
}

/// From correspondences to the refined motion: RGN, RGE, GNC and FR.
void RowsToMotion(const FacadePair& p, const ExecutionContext& context) {
  const auto hypotheses = Hypotheses(Reliable(p.rows, context), context);
  if (hypotheses.empty()) return;
  const RigidTransform motion =
      RefineOnInliers(p.rows, hypotheses[0].target_from_source, 3.0 * kResolution);
  const GncWelschResult gnc = Estimate(Inliers(p.rows, motion), motion);
  benchmark::DoNotOptimize(Fine(p, gnc.target_from_source, gnc.information, context));
}

void BM_Matching(benchmark::State& state) {
  OverPairs(state, [](const FacadePair& p) {
    benchmark::DoNotOptimize(
        MatchDescriptors(p.source->features.descriptors, p.target->features.descriptors, {}));
  });
}

/// Matches that only one of the two has.
std::size_t Differing(const std::vector<DescriptorMatch>& a,
                      const std::vector<DescriptorMatch>& b) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ours, theirs, differing;
  for (const DescriptorMatch& m : a) ours.emplace_back(m.source, m.target);
  for (const DescriptorMatch& m : b) theirs.emplace_back(m.source, m.target);
  std::sort(ours.begin(), ours.end());
  std::sort(theirs.begin(), theirs.end());
  std::set_symmetric_difference(ours.begin(), ours.end(), theirs.begin(), theirs.end(),
                                std::back_inserter(differing));
  return differing.size();
}

void BM_MatchingPcl(benchmark::State& state) {
  OverPairs(state, [](const FacadePair& p) {
    benchmark::DoNotOptimize(
        PclMatches(p.source->features.descriptors, p.target->features.descriptors, 5));
  });
  std::size_t matches = 0;
  std::size_t differing = 0;
  for (const FacadePair& p : TheFacade().pairs) {
    const auto theirs =
        PclMatches(p.source->features.descriptors, p.target->features.descriptors, 5);
    matches += theirs.size();
    differing += Differing(
        MatchDescriptors(p.source->features.descriptors, p.target->features.descriptors, {}),
        theirs);
  }
  state.counters["matches"] = static_cast<double>(matches);
  state.counters["that_differ"] = static_cast<double>(differing);
}

/// Descriptors as of real surfaces: some hundred kinds, three histograms of 100 per cent each.
std::vector<FpfhDescriptor> SyntheticDescriptors(std::uint64_t seed, std::size_t count) {
  Random kinds_random(1);
  std::vector<FpfhDescriptor> kinds(300);
  for (FpfhDescriptor& kind : kinds) {
    for (float& bin : kind) bin = static_cast<float>(std::pow(kinds_random.Uniform(), 4.0));
  }
  Random random(seed);
  std::vector<FpfhDescriptor> descriptors(count);
  for (FpfhDescriptor& d : descriptors) {
    const FpfhDescriptor& kind = kinds[random.Index(kinds.size())];
    for (std::size_t group = 0; group < 3; ++group) {
      float sum = 0.0F;
      for (std::size_t bin = 11 * group; bin < 11 * group + 11; ++bin) {
        d[bin] = kind[bin] * static_cast<float>(std::exp(0.5 * random.Normal()));
        sum += d[bin];
      }
      for (std::size_t bin = 11 * group; bin < 11 * group + 11; ++bin) d[bin] *= 100.0F / sum;
    }
  }
  return descriptors;
}

void BM_Matching8k(benchmark::State& state) {
  const auto source = SyntheticDescriptors(2, 8000);
  const auto target = SyntheticDescriptors(3, 8000);
  for (auto _ : state) benchmark::DoNotOptimize(MatchDescriptors(source, target, {}));
}

void BM_Matching8kPcl(benchmark::State& state) {
  const auto source = SyntheticDescriptors(2, 8000);
  const auto target = SyntheticDescriptors(3, 8000);
  std::vector<DescriptorMatch> theirs;
  for (auto _ : state) theirs = PclMatches(source, target, 5);
  state.counters["matches"] = static_cast<double>(theirs.size());
  state.counters["that_differ"] =
      static_cast<double>(Differing(MatchDescriptors(source, target, {}), theirs));
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
    benchmark::DoNotOptimize(Fine(p, p.coarse, Matrix6d::Identity() * 1e4, context));
  });
}

void BM_FineWithoutSurfaces(benchmark::State& state) {
  const ExecutionContext context(1);
  FineOptions options;
  options.surfaces = false;
  OverPairs(state, [&](const FacadePair& p) {
    benchmark::DoNotOptimize(RefinePair({p.source->surface(),
                                         p.target->surface(),
                                         *p.target->index,
                                         p.coarse,
                                         Matrix6d::Identity() * 1e4,
                                         {}},
                                        options, context));
  });
}

void BM_GicpPcl(benchmark::State& state) {
  OverPairs(state, [](const FacadePair& p) {
    benchmark::DoNotOptimize(
        PclGicp(p.source->index->means, p.target->index->means, p.coarse, 2.0 * kResolution));
  });
}

void BM_PointToPlanePcl(benchmark::State& state) {
  OverPairs(state, [](const FacadePair& p) {
    benchmark::DoNotOptimize(PclPointToPlane(p.source->index->means, p.target->index->means,
                                             p.target->features.normals, p.coarse,
                                             2.0 * kResolution));
  });
}

void BM_RowsToMotion(benchmark::State& state) {
  const ExecutionContext context(static_cast<int>(state.range(0)));
  OverPairs(state, [&](const FacadePair& p) { RowsToMotion(p, context); });
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

BENCHMARK(BM_Matching)->UseManualTime()->Iterations(42)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_MatchingPcl)->UseManualTime()->Iterations(21)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Matching8k)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Matching8kPcl)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Rgn)->Arg(1)->Arg(0)->UseManualTime()->Iterations(84)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Rge)->Arg(1)->Arg(0)->UseManualTime()->Iterations(84)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Gnc)->UseManualTime()->Iterations(84)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Fine)->UseManualTime()->Iterations(84)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_FineWithoutSurfaces)->UseManualTime()->Iterations(84)->Unit(benchmark::kMillisecond);
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
