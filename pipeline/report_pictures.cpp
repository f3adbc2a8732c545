#include "pipeline/report_pictures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "pipeline/picture_canvas.h"
#include "pipeline/placed_clouds.h"
#include "pipeline/plan_pictures.h"
#include "pipeline/section_pictures.h"

namespace backsight {
namespace {

/// Those of the main component.
std::vector<DistanceSample> MainSamples(const Network& network, const SurfaceDistances& distances) {
  std::vector<DistanceSample> samples;
  for (const PairDistances& pair : distances.pairs) {
    if (network.component[static_cast<std::size_t>(pair.a)] != 0) continue;
    samples.insert(samples.end(), pair.samples.begin(), pair.samples.end());
  }
  return samples;
}

/// A round length that 95 % of the distances do not exceed.
double ScaleLimit(const std::vector<DistanceSample>& samples) {
  constexpr double kFinest = 1e-3;
  std::vector<double> values;
  values.reserve(samples.size());
  for (const DistanceSample& sample : samples) values.push_back(sample.distance_m);
  const auto p95 = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 95 / 100);
  std::nth_element(values.begin(), p95, values.end());
  return RoundUp(std::max(*p95, kFinest));
}

}  // namespace

std::vector<PictureRecord> DrawReportPictures(const std::vector<Station>& stations,
                                              const Network& network,
                                              const GeoreferencedNetwork& ground,
                                              const SurfaceDistances& distances,
                                              const ExecutionContext& context) {
  const PlacedClouds clouds = PlaceClouds(stations, network, ground);
  if (clouds.voxels() == 0) return {};
  const CloudExtent extent = ExtentOf(clouds);
  const std::vector<DistanceSample> samples = MainSamples(network, distances);
  std::vector<NamedSection> sections = ChooseSections(extent, samples);
  if (const auto worst = ChooseWorst(extent, samples)) sections.push_back(*worst);
  using Pictures = std::vector<PictureRecord>;
  const std::vector<std::function<Pictures()>> draw = {
      [&] { return Pictures{DrawDensity(clouds, extent, TracesOf(sections), context)}; },
      [&] { return Pictures{DrawHeights(clouds, extent, context)}; },
      [&] { return DrawSections(clouds, sections, context); },
      [&] {
        if (samples.empty()) return Pictures{};
        const DistanceLimits limits{ScaleLimit(samples), distances.search_m};
        return Pictures{DrawDistances(clouds, extent, samples, limits, context)};
      }};
  std::vector<Pictures> drawn(draw.size());
  context.ParallelFor(draw.size(), [&](std::size_t i) { drawn[i] = draw[i](); });
  Pictures pictures;
  for (Pictures& some : drawn) std::move(some.begin(), some.end(), std::back_inserter(pictures));
  return pictures;
}

}  // namespace backsight
