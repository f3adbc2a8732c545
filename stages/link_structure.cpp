#include "stages/link_structure.h"

#include <algorithm>

namespace backsight {
namespace {

using Candidates = std::span<const PairProspect>;

std::size_t At(int index) { return static_cast<std::size_t>(index); }

/// Numbers groups from 0 by their first member.
std::vector<int> Renumber(const std::vector<int>& group) {
  std::vector<int> number(group.size(), -1);
  std::vector<int> renumbered;
  renumbered.reserve(group.size());
  int next = 0;
  for (const int g : group) {
    if (number[At(g)] < 0) number[At(g)] = next++;
    renumbered.push_back(number[At(g)]);
  }
  return renumbered;
}

/// Tarjan's bridges by depth-first search: stations that no bridge parts share their lowest entry.
class BlockFinder {
 public:
  BlockFinder(int stations, Candidates candidates)
      : neighbors_(At(stations)), entry_(At(stations), -1), low_(At(stations), 0) {
    for (const PairProspect& pair : candidates) {
      if (!pair.accepted) continue;
      neighbors_[At(pair.source)].push_back(pair.target);
      neighbors_[At(pair.target)].push_back(pair.source);
    }
    component_.resize(At(stations), 0);
    block_.resize(At(stations), 0);
    for (int s = 0; s < stations; ++s) {
      if (entry_[At(s)] < 0) Visit(s, /*parent=*/-1, /*root=*/s);
    }
  }
  const std::vector<int>& component() const { return component_; }
  const std::vector<int>& block() const { return block_; }

 private:
  /// Depth is at most the number of stations.
  void Visit(int station, int parent, int root) {
    entry_[At(station)] = low_[At(station)] = clock_++;
    component_[At(station)] = root;
    open_.push_back(station);
    for (const int next : neighbors_[At(station)]) {
      if (next == parent) continue;
      if (entry_[At(next)] < 0) {
        Visit(next, station, root);
        low_[At(station)] = std::min(low_[At(station)], low_[At(next)]);
      } else {
        low_[At(station)] = std::min(low_[At(station)], entry_[At(next)]);
      }
    }
    if (low_[At(station)] < entry_[At(station)]) return;
    int member = -1;
    while (member != station) {
      member = open_.back();
      open_.pop_back();
      block_[At(member)] = station;
    }
  }

  std::vector<std::vector<int>> neighbors_;
  std::vector<int> entry_;
  std::vector<int> low_;
  std::vector<int> component_;
  std::vector<int> block_;
  std::vector<int> open_;
  int clock_ = 0;
};

}  // namespace

LinkStructure FindLinkStructure(int stations, Candidates candidates) {
  const BlockFinder finder(stations, candidates);
  LinkStructure structure;
  structure.component = Renumber(finder.component());
  structure.block = Renumber(finder.block());
  structure.links.resize(At(stations), 0);
  for (const PairProspect& pair : candidates) {
    if (!pair.accepted) continue;
    ++structure.links[At(pair.source)];
    ++structure.links[At(pair.target)];
  }
  return structure;
}

}  // namespace backsight
