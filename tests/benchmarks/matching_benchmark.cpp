#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/random.h"
#include "stages/matching.h"
#include "tests/benchmarks/facade_pairs.h"
#include "tests/benchmarks/pcl_registration.h"

// Matching of descriptors on the pairs of ETH Facade and on synthetic ones, beside PCL.

namespace backsight {
namespace {

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

/// Nearest descriptors of each, all distances summed in double.
std::vector<std::vector<std::uint32_t>> ExactNearest(std::span<const FpfhDescriptor> queries,
                                                     std::span<const FpfhDescriptor> others) {
  std::vector<std::vector<std::uint32_t>> nearest;
  std::vector<std::pair<double, std::uint32_t>> all(others.size());
  for (const FpfhDescriptor& query : queries) {
    for (std::uint32_t j = 0; j < others.size(); ++j) {
      double squared = 0.0;
      for (std::size_t bin = 0; bin < query.size(); ++bin) {
        const double d = static_cast<double>(query[bin]) - static_cast<double>(others[j][bin]);
        squared += d * d;
      }
      all[j] = {squared, j};
    }
    const auto end =
        all.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(5, all.size()));
    std::partial_sort(all.begin(), end, all.end());
    nearest.emplace_back();
    for (auto n = all.begin(); n != end; ++n) nearest.back().push_back(n->second);
  }
  return nearest;
}

std::vector<DescriptorMatch> ExactMatches(std::span<const FpfhDescriptor> source,
                                          std::span<const FpfhDescriptor> target) {
  const auto there = ExactNearest(source, target);
  const auto back = ExactNearest(target, source);
  std::vector<DescriptorMatch> matches;
  for (std::uint32_t s = 0; s < source.size(); ++s) {
    for (const std::uint32_t t : there[s]) {
      if (std::find(back[t].begin(), back[t].end(), s) != back[t].end()) matches.push_back({s, t});
    }
  }
  return matches;
}

/// Our matches and PCL's beside those of all distances.
struct Compared {
  std::size_t matches = 0, ours_differ = 0, theirs_differ = 0;
  Compared& operator+=(const Compared& other) {
    matches += other.matches;
    ours_differ += other.ours_differ;
    theirs_differ += other.theirs_differ;
    return *this;
  }
};

Compared Compare(std::span<const FpfhDescriptor> source, std::span<const FpfhDescriptor> target) {
  const auto exact = ExactMatches(source, target);
  return {exact.size(), Differing(MatchDescriptors(source, target, {}), exact),
          Differing(PclMatches(source, target, 5), exact)};
}

void Report(const Compared& compared, benchmark::State* state) {
  state->counters["matches"] = static_cast<double>(compared.matches);
  state->counters["ours_differ"] = static_cast<double>(compared.ours_differ);
  state->counters["theirs_differ"] = static_cast<double>(compared.theirs_differ);
}

void BM_MatchingPcl(benchmark::State& state) {
  OverPairs(state, [](const FacadePair& p) {
    benchmark::DoNotOptimize(
        PclMatches(p.source->features.descriptors, p.target->features.descriptors, 5));
  });
  Compared all;
  for (const FacadePair& p : TheFacade().pairs) {
    all += Compare(p.source->features.descriptors, p.target->features.descriptors);
  }
  Report(all, &state);
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
  for (auto _ : state) benchmark::DoNotOptimize(PclMatches(source, target, 5));
  Report(Compare(source, target), &state);
}

BENCHMARK(BM_Matching)->UseManualTime()->Iterations(42)->Unit(benchmark::kMillisecond);
/// Those of every other station of ETH Facade from `first` on, thrown together: 7,054 and 5,895.
std::vector<FpfhDescriptor> DescriptorsOfEveryOther(std::size_t first) {
  const auto& stations = TheFacade().stations;
  std::vector<FpfhDescriptor> all;
  for (std::size_t s = first; s < stations.size(); s += 2) {
    const auto& descriptors = stations[s].features.descriptors;
    all.insert(all.end(), descriptors.begin(), descriptors.end());
  }
  return all;
}

void BM_MatchingTogether(benchmark::State& state) {
  const auto source = DescriptorsOfEveryOther(0);
  const auto target = DescriptorsOfEveryOther(1);
  for (auto _ : state) benchmark::DoNotOptimize(MatchDescriptors(source, target, {}));
}

void BM_MatchingTogetherPcl(benchmark::State& state) {
  const auto source = DescriptorsOfEveryOther(0);
  const auto target = DescriptorsOfEveryOther(1);
  for (auto _ : state) benchmark::DoNotOptimize(PclMatches(source, target, 5));
  Report(Compare(source, target), &state);
}

BENCHMARK(BM_MatchingPcl)->UseManualTime()->Iterations(21)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_MatchingTogether)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_MatchingTogetherPcl)->Iterations(3)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Matching8k)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Matching8kPcl)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace backsight
