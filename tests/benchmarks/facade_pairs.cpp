#include "tests/benchmarks/facade_pairs.h"

#include <fmt/format.h>

#include <cstdlib>
#include <numbers>

#include "graph/correspondence_graph.h"
#include "graph/rigid_fit.h"
#include "io/pose_files.h"
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

/// Of the instrument frames.
RigidTransform TrueMotion(const std::map<std::string, RigidTransform>& survey_from_station,
                          const Station& source, const Station& target) {
  const auto survey_from_instrument = [&](const Station& station) {
    return survey_from_station.at(station.spec.id) * station.model.StationFromInstrument();
  };
  return survey_from_instrument(target).Inverse() * survey_from_instrument(source);
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
  if (stations.empty()) return;
  const ExecutionContext context(0);
  const auto truth = ReadPoses(fmt::format("{}/eth_facade", std::getenv("BACKSIGHT_DATA")));
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
    p.truth = TrueMotion(truth, *p.source, *p.target);
    p.target_planes = p.target->prepared.Planes(p.target->surface(), {});
    pairs.push_back(std::move(p));
  }
}

void ReportErrors(const std::function<RigidTransform(const FacadePair&)>& motion_of,
                  benchmark::State* state) {
  std::vector<double> re_deg, te_mm;
  for (const FacadePair& p : TheFacade().pairs) {
    const RigidTransform motion = motion_of(p);
    re_deg.push_back(RotationAngle(motion.rotation, p.truth.rotation) * 180.0 / std::numbers::pi);
    te_mm.push_back(1e3 * (motion.translation - p.truth.translation).norm());
  }
  if (re_deg.empty()) return;
  std::sort(re_deg.begin(), re_deg.end());
  std::sort(te_mm.begin(), te_mm.end());
  state->counters["re_median_deg"] = re_deg[re_deg.size() / 2];
  state->counters["re_max_deg"] = re_deg.back();
  state->counters["te_median_mm"] = te_mm[te_mm.size() / 2];
  state->counters["te_max_mm"] = te_mm.back();
}

const Facade& TheFacade() {
  static const Facade facade;
  return facade;
}

}  // namespace backsight
