#include "graph/pair_planes.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "graph/plane_judge.h"

namespace backsight {
namespace {

constexpr std::uint32_t kAlone = ~0U;
constexpr std::uint64_t kAnyKey = 0;

}  // namespace

/// From the cells that both stations see down to planes.
class PairPlaneSearch::Descent {
 public:
  Descent(const PlaneTree& tree, const ClusterList& second, std::span<const RigidTransform> poses,
          const PlaneSearchOptions& options, std::vector<PlaneAssociation>* planes)
      : tree_(tree), second_(second), options_(options), judge_(options, poses), planes_(planes) {}

  /// `entries` are what the second station has in the cell of `node`, ascending; they come out in
  /// another order. `cell`: its coordinates in cells of its own depth.
  void Split(const PlaneTree::Node& node, std::span<PathEntry> entries, const Eigen::Vector3i& cell,
             int depth) {
    if (!HasEnough(Points(entries), static_cast<int>(entries.size()), options_)) return;
    if (node.is_planar && Accept(node, entries, cell, depth)) return;
    if (depth == options_.max_depth) return;
    const std::array<std::uint32_t, 9> begins = SortIntoOctants(entries, depth + 1);
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      const PlaneTree::Node* child = tree_.Child(node, octant);
      if (child == nullptr || begins[octant] == begins[octant + 1]) continue;
      const Eigen::Vector3i low(static_cast<int>(octant >> 2U), static_cast<int>(octant >> 1U & 1U),
                                static_cast<int>(octant & 1U));
      Split(*child, entries.subspan(begins[octant], begins[octant + 1] - begins[octant]),
            2 * cell + low, depth + 1);
    }
  }

 private:
  double Points(std::span<const PathEntry> entries) const {
    if (static_cast<int>(entries.size()) >= options_.min_clusters) return 0.0;  // they suffice
    double points = 0.0;
    for (const PathEntry& entry : entries) points += second_.Count(entry.cluster);
    return points;
  }

  /// Brings the entries octant by octant, in their order; returns where each begins, and the end.
  std::array<std::uint32_t, 9> SortIntoOctants(std::span<PathEntry> entries, int depth) {
    std::array<std::uint32_t, 9> begins{};
    for (const PathEntry& entry : entries) ++begins[OctreeCells::Octant(entry.path, depth) + 1];
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    unsorted_.assign(entries.begin(), entries.end());
    std::array<std::uint32_t, 9> next = begins;
    for (const PathEntry& entry : unsorted_) {
      entries[next[OctreeCells::Octant(entry.path, depth)]++] = entry;
    }
    return begins;
  }

  bool Accept(const PlaneTree::Node& node, std::span<const PathEntry> entries,
              const Eigen::Vector3i& cell, int depth) {
    ClusterSum sum;
    for (const PathEntry& entry : entries) sum.Add(second_[entry.cluster]);
    judge_.Clear();
    judge_.Add(0, node.Local());
    judge_.Add(1, sum.Sum());
    PlaneAssociation plane;
    if (!judge_.Judge(&plane.observations)) return false;
    plane.cell = PlaneCell(cell, depth);
    planes_->push_back(std::move(plane));
    return true;
  }

  const PlaneTree& tree_;
  const ClusterList& second_;
  const PlaneSearchOptions& options_;
  PlaneJudge judge_;
  std::vector<PathEntry> unsorted_;
  std::vector<PlaneAssociation>* planes_;
};

PairPlaneSearch::PairPlaneSearch(const PlaneTree& first, const ClusterList& second)
    : first_(first),
      second_(second),
      keys_(second.size(), kAnyKey),
      places_(second.size(), first.FindRoot(OctreeCells::Root(kAnyKey)).value_or(kAlone)) {
  by_root_.reserve(second.size());
}

/// Finds the clusters' subcells and their roots among the first station's, and counts what is in
/// each root. Most are in that of the last search.
void PairPlaneSearch::FindRoots(const SubcellFinder& subcells) {
  begins_.assign(first_.roots() + 1, 0);
  std::uint64_t last_root = OctreeCells::Root(kAnyKey);
  std::uint32_t place = first_.FindRoot(last_root).value_or(kAlone);
  subcells.ForRuns(second_, [&](std::size_t begin, std::span<const std::uint64_t> keys) {
    for (std::size_t k = 0; k < keys.size(); ++k) {
      const std::size_t i = begin + k;
      const std::uint64_t root = OctreeCells::Root(keys[k]);
      if (root != OctreeCells::Root(keys_[i])) {
        if (root != last_root) {  // clusters come by their voxels: many follow one of their own
          last_root = root;
          place = first_.FindRoot(root).value_or(kAlone);
        }
        places_[i] = place;
      }
      keys_[i] = keys[k];
      if (places_[i] != kAlone) ++begins_[places_[i] + 1];
    }
  });
  std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
}

/// Gathers the clusters in the first station's root cells.
void PairPlaneSearch::SortIntoRoots() {
  by_root_.resize(begins_.back());
  for (std::uint32_t i = 0; i < places_.size(); ++i) {
    if (places_[i] != kAlone) by_root_[begins_[places_[i]]++] = i;
  }
  // Every begin has moved on to the next one.
  std::rotate(begins_.begin(), begins_.end() - 1, begins_.end());
  begins_.front() = 0;
}

std::vector<PlaneAssociation> PairPlaneSearch::Find(const RigidTransform& lattice_from_second,
                                                    const PlaneSearchOptions& options) {
  FindRoots({lattice_from_second, options.root_edge_m});
  SortIntoRoots();
  std::vector<PlaneAssociation> planes;
  const std::array<RigidTransform, 2> poses{first_.lattice_from_station(), lattice_from_second};
  Descent descent(first_, second_, poses, options, &planes);
  for (std::size_t place = 0; place < first_.roots(); ++place) {
    const auto clusters =
        std::span(by_root_).subspan(begins_[place], begins_[place + 1] - begins_[place]);
    if (clusters.empty()) continue;
    cell_.clear();
    for (const std::uint32_t i : clusters) cell_.push_back({i, OctreeCells::Path(keys_[i])});
    descent.Split(first_.Root(place), cell_, OctreeCells::RootCell(first_.RootKey(place)), 0);
  }
  return planes;
}

}  // namespace backsight
