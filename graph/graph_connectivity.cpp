#include "graph/graph_connectivity.h"

#include <algorithm>

namespace backsight {
namespace {

struct Step {
  int station;
  int link;
};

class Neighbours {
 public:
  Neighbours(int stations, std::span<const PoseGraphLink> links, std::span<const char> use)
      : of_(static_cast<std::size_t>(stations)) {
    for (std::size_t l = 0; l < links.size(); ++l) {
      if (!use.empty() && use[l] == 0) continue;
      const int link = static_cast<int>(l);
      of_[static_cast<std::size_t>(links[l].source)].push_back({links[l].target, link});
      of_[static_cast<std::size_t>(links[l].target)].push_back({links[l].source, link});
    }
  }
  const std::vector<Step>& Of(int station) const { return of_[static_cast<std::size_t>(station)]; }

 private:
  std::vector<std::vector<Step>> of_;
};

}  // namespace

std::vector<int> FindComponents(int stations, std::span<const PoseGraphLink> links,
                                std::span<const char> use) {
  const Neighbours neighbours(stations, links, use);
  std::vector<int> component(static_cast<std::size_t>(stations), -1);
  int count = 0;
  for (int first = 0; first < stations; ++first) {
    if (component[static_cast<std::size_t>(first)] >= 0) continue;
    std::vector<int> open{first};
    component[static_cast<std::size_t>(first)] = count;
    while (!open.empty()) {
      const int station = open.back();
      open.pop_back();
      for (const Step& step : neighbours.Of(station)) {
        int& other = component[static_cast<std::size_t>(step.station)];
        if (other >= 0) continue;
        other = count;
        open.push_back(step.station);
      }
    }
    ++count;
  }
  return component;
}

std::vector<char> FindBridges(int stations, std::span<const PoseGraphLink> links,
                              std::span<const char> use) {
  const Neighbours neighbours(stations, links, use);
  std::vector<char> bridge(links.size(), 0);
  const auto count = static_cast<std::size_t>(stations);
  std::vector<int> entry(count, -1);  // order of discovery
  std::vector<int> low(count, 0);     // earliest station reached from below without the way down
  std::vector<std::size_t> next(count, 0);
  int clock = 0;
  for (int root = 0; root < stations; ++root) {
    if (entry[static_cast<std::size_t>(root)] >= 0) continue;
    std::vector<Step> path{{root, -1}};
    entry[static_cast<std::size_t>(root)] = low[static_cast<std::size_t>(root)] = clock++;
    while (!path.empty()) {
      const Step here = path.back();
      const auto s = static_cast<std::size_t>(here.station);
      if (next[s] < neighbours.Of(here.station).size()) {
        const Step step = neighbours.Of(here.station)[next[s]++];
        const auto t = static_cast<std::size_t>(step.station);
        if (step.link == here.link) continue;
        if (entry[t] >= 0) {
          low[s] = std::min(low[s], entry[t]);
        } else {
          entry[t] = low[t] = clock++;
          path.push_back(step);
        }
        continue;
      }
      path.pop_back();
      if (path.empty()) continue;
      const auto parent = static_cast<std::size_t>(path.back().station);
      low[parent] = std::min(low[parent], low[s]);
      if (low[s] > entry[parent]) bridge[static_cast<std::size_t>(here.link)] = 1;
    }
  }
  return bridge;
}

int CountDisjointPaths(int stations, std::span<const PoseGraphLink> links,
                       std::span<const char> use, int from, int to, int limit) {
  const Neighbours neighbours(stations, links, use);
  // Flow over a link: +1 from source to target, -1 back; it may be cancelled once and then turned.
  std::vector<int> flow(links.size(), 0);
  for (int found = 0; found < limit; ++found) {
    std::vector<Step> came(static_cast<std::size_t>(stations), Step{-1, -1});
    std::vector<int> open{from};
    came[static_cast<std::size_t>(from)].station = from;
    for (std::size_t k = 0; k < open.size() && came[static_cast<std::size_t>(to)].station < 0;
         ++k) {
      for (const Step& step : neighbours.Of(open[k])) {
        const auto l = static_cast<std::size_t>(step.link);
        const int direction = links[l].source == open[k] ? 1 : -1;
        Step& other = came[static_cast<std::size_t>(step.station)];
        if (other.station >= 0 || flow[l] == direction) continue;
        other = {open[k], step.link};
        open.push_back(step.station);
      }
    }
    if (came[static_cast<std::size_t>(to)].station < 0) return found;
    for (int s = to; s != from; s = came[static_cast<std::size_t>(s)].station) {
      const Step& step = came[static_cast<std::size_t>(s)];
      const auto l = static_cast<std::size_t>(step.link);
      flow[l] += links[l].source == step.station ? 1 : -1;
    }
  }
  return limit;
}

}  // namespace backsight
