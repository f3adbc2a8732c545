#include "pipeline/distance_records.h"

#include <algorithm>
#include <cmath>

#include "pipeline/placed_clouds.h"

namespace backsight {
namespace {

/// Sorted distances of samples.
std::vector<double> Distances(const std::vector<DistanceSample>& samples) {
  std::vector<double> distances;
  distances.reserve(samples.size());
  for (const DistanceSample& sample : samples) distances.push_back(sample.distance_m);
  std::sort(distances.begin(), distances.end());
  return distances;
}

/// The smallest value that the share `p` of the values does not exceed.
double Quantile(const std::vector<double>& sorted, double p) {
  const auto rank = static_cast<std::size_t>(std::ceil(p * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

DistanceFigures Figures(const std::vector<double>& sorted) {
  return {sorted.size(), Quantile(sorted, 0.5), Quantile(sorted, 0.68), Quantile(sorted, 0.95)};
}

/// Bins of a round width that reach well beyond 95 % of the samples.
void FillHistogram(const std::vector<double>& sorted, DistanceRecord* record) {
  constexpr std::size_t kBins = 60;
  constexpr double kReach = 1.25;  // of the 95 % quantile
  constexpr double kFinest = 1e-5;
  const double wanted = std::max(kReach * record->total.p95_m / kBins, kFinest);
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  record->bin_m = 10.0 * decade;
  for (const double step : {5.0, 2.5, 2.0, 1.0}) {
    if (step * decade >= wanted) record->bin_m = step * decade;
  }
  record->bins.assign(kBins, 0);
  for (const double distance : sorted) {
    const auto bin = static_cast<std::size_t>(distance / record->bin_m);
    ++(bin < kBins ? record->bins[bin] : record->beyond);
  }
}

}  // namespace

SurfaceDistances MeasureStationDistances(const std::vector<Station>& stations,
                                         const Network& network, const GeoreferencedNetwork& ground,
                                         const ExecutionContext& context) {
  std::vector<PlacedCloud> clouds;
  std::vector<int> indices;
  for (std::size_t s = 0; s < stations.size(); ++s) {
    const std::optional<RigidTransform> place = DeliveredPlace(network, ground, s);
    if (!stations[s].usable() || !place) continue;
    indices.push_back(static_cast<int>(s));
    clouds.push_back({stations[s].surface(), *stations[s].index,
                      *place * stations[s].model.StationFromInstrument(), network.component[s]});
  }
  SurfaceDistances distances = MeasureSurfaceDistances(clouds, context);
  for (PairDistances& pair : distances.pairs) {
    pair.a = indices[static_cast<std::size_t>(pair.a)];
    pair.b = indices[static_cast<std::size_t>(pair.b)];
  }
  return distances;
}

std::optional<DistanceRecord> MakeDistanceRecord(const std::vector<Station>& stations,
                                                 const SurfaceDistances& distances) {
  if (distances.pairs.empty()) return std::nullopt;
  const auto id = [&](int station) { return stations[static_cast<std::size_t>(station)].spec.id; };
  DistanceRecord record;
  record.search_m = distances.search_m;
  std::vector<double> all;
  for (const PairDistances& pair : distances.pairs) {
    const std::vector<double> sorted = Distances(pair.samples);
    record.pairs.push_back({{id(pair.a), id(pair.b)}, Figures(sorted)});
    all.insert(all.end(), sorted.begin(), sorted.end());
  }
  std::sort(all.begin(), all.end());
  record.total = Figures(all);
  FillHistogram(all, &record);
  return record;
}

}  // namespace backsight
