#include "graph/plane_tree.h"

#include <algorithm>
#include <array>
#include <bit>

#include "core/error.h"
#include "core/key_slot.h"
#include "graph/subcell_finder.h"

namespace backsight {
namespace {

struct KeyedEntry {
  std::uint64_t root;
  PathEntry entry;
};

/// By root cell, path and cluster.
std::vector<KeyedEntry> SortIntoCells(const ClusterList& clusters, const SubcellFinder& subcells) {
  std::vector<KeyedEntry> entries;
  entries.reserve(clusters.size());
  subcells.ForRuns(clusters, [&](std::size_t first, std::span<const std::uint64_t> keys) {
    for (std::size_t i = 0; i < keys.size(); ++i) {
      entries.push_back({OctreeCells::Root(keys[i]),
                         {static_cast<std::uint32_t>(first + i), OctreeCells::Path(keys[i])}});
    }
  });
  std::sort(entries.begin(), entries.end(), [](const KeyedEntry& a, const KeyedEntry& b) {
    if (a.root != b.root) return a.root < b.root;
    return a.entry.path != b.entry.path ? a.entry.path < b.entry.path
                                        : a.entry.cluster < b.entry.cluster;
  });
  return entries;
}

}  // namespace

PlaneTree::PlaneTree(const ClusterList& clusters, const RigidTransform& lattice_from_station,
                     const PlaneSearchOptions& options)
    : options_(options), lattice_from_station_(lattice_from_station) {
  BACKSIGHT_CHECK(options.max_depth <= OctreeCells::kDepth, "cells are split three times");
  const std::vector<KeyedEntry> sorted =
      SortIntoCells(clusters, {lattice_from_station, options.root_edge_m});
  std::vector<PathEntry> cell;
  for (std::size_t i = 0; i < sorted.size();) {
    cell.clear();
    const std::uint64_t root = sorted[i].root;
    for (; i < sorted.size() && sorted[i].root == root; ++i) cell.push_back(sorted[i].entry);
    const std::uint32_t node = AddNode(cell, 0, clusters);
    if (node == kNone) continue;
    root_keys_.push_back(root);
    root_nodes_.push_back(node);
    AddChildren(node, cell, 1, clusters);
  }
  MakeSlots();
}

/// kNone where no plane can come of it.
std::uint32_t PlaneTree::AddNode(std::span<const PathEntry> entries, int depth,
                                 const ClusterList& clusters) {
  ClusterSum sum;
  for (const PathEntry& entry : entries) sum.Add(clusters[entry.cluster]);
  const PointCluster local = sum.Sum();
  if (!HasEnough(local.count, static_cast<int>(entries.size()), options_)) return kNone;
  PlaneFit fit;
  FitPlanes(std::span(&local, 1), /*normals=*/false, std::span(&fit, 1));
  const bool is_planar = IsPlanar(fit, options_);
  if (!is_planar && depth == options_.max_depth) return kNone;
  if (node_count_ % kBlock == 0) blocks_.emplace_back().reserve(kBlock);
  blocks_.back().push_back(
      {.mean = local.mean, .spread = ClusterSpread(local), .is_planar = is_planar});
  return node_count_++;
}

/// The octants of a node at `depth` - 1, whose entries ascend by path, and theirs.
void PlaneTree::AddChildren(std::uint32_t node, std::span<const PathEntry> entries, int depth,
                            const ClusterList& clusters) {
  if (depth > options_.max_depth) return;
  std::array<std::span<const PathEntry>, 8> of_octant;
  for (std::size_t begin = 0; begin < entries.size();) {
    const std::uint32_t octant = OctreeCells::Octant(entries[begin].path, depth);
    std::size_t end = begin;
    while (end < entries.size() && OctreeCells::Octant(entries[end].path, depth) == octant) ++end;
    of_octant[octant] = entries.subspan(begin, end - begin);
    begin = end;
  }
  const std::uint32_t first = node_count_;
  NodeAt(node).first_child = first;
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    if (of_octant[octant].empty() || AddNode(of_octant[octant], depth, clusters) == kNone) continue;
    NodeAt(node).octants |= static_cast<std::uint8_t>(1U << octant);
  }
  std::uint32_t child = first;
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    if ((NodeAt(node).octants >> octant & 1U) == 0U) continue;
    AddChildren(child++, of_octant[octant], depth + 1, clusters);
  }
}

void PlaneTree::MakeSlots() {
  slots_.assign(std::bit_ceil(2 * root_keys_.size() + 1), {});
  for (std::uint32_t place = 0; place < root_keys_.size(); ++place) {
    std::size_t slot = KeySlot(root_keys_[place], slots_.size() - 1);
    while (slots_[slot].place != kNone) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = {root_keys_[place], place};
  }
}

std::optional<std::uint32_t> PlaneTree::FindRoot(std::uint64_t key) const {
  for (std::size_t slot = KeySlot(key, slots_.size() - 1);;
       slot = (slot + 1) & (slots_.size() - 1)) {
    if (slots_[slot].place == kNone) return std::nullopt;
    if (slots_[slot].key == key) return slots_[slot].place;
  }
}

const PlaneTree::Node* PlaneTree::Child(const Node& node, std::uint32_t octant) const {
  if ((node.octants >> octant & 1U) == 0U) return nullptr;
  const auto before = static_cast<unsigned>(node.octants & ((1U << octant) - 1U));
  return &NodeAt(node.first_child + static_cast<std::uint32_t>(std::popcount(before)));
}

}  // namespace backsight
