#include "tests/benchmarks/facade_pairs.h"

#include <fmt/format.h>

#include <cstdlib>

#include "graph/correspondence_graph.h"
#include "graph/rigid_fit.h"
#include "stages/coarse_registration.h"
#include "stages/matching.h"

namespace backsight {
namespace {

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

}  // namespace

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

Facade::Facade() : stations(LoadFacade()) {
  const ExecutionContext context(0);
  for (const Pair& planned : PlanPairs(stations, {})) {
    FacadePair p;
    p.pair = planned;
    p.source = &stations[static_cast<std::size_t>(planned.source)];
    p.target = &stations[static_cast<std::size_t>(planned.target)];
    p.rows =
        MatchStations(p.source->model, p.source->features, p.target->model, p.target->features, {});
    p.reliable = Reliable(p.rows, context);
    const auto hypotheses = Hypotheses(p.reliable, context);
    if (hypotheses.empty()) continue;
    p.coarse = RefineOnInliers(p.rows, hypotheses[0].target_from_source, 3.0 * kResolution);
    p.inliers = Inliers(p.rows, p.coarse);
    pairs.push_back(std::move(p));
  }
}

const Facade& TheFacade() {
  static const Facade facade;
  return facade;
}

}  // namespace backsight
