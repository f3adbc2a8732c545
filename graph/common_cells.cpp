#include "graph/common_cells.h"

#include <algorithm>
#include <numeric>

#include "core/key_slot.h"
#include "graph/for_each.h"

namespace backsight {
namespace {

/// Numbers distinct keys from 0 in the order of their coming.
class KeyNumbers {
 public:
  KeyNumbers() : slots_(kFewest) {}

  std::uint32_t Number(std::uint64_t key) {
    if (2 * keys_.size() >= slots_.size()) Grow();
    Slot& slot = slots_[Find(key)];
    if (slot.number == kNone) {
      slot = {key, static_cast<std::uint32_t>(keys_.size())};
      keys_.push_back(key);
    }
    return slot.number;
  }
  const std::vector<std::uint64_t>& keys() const { return keys_; }

 private:
  static constexpr std::size_t kFewest = 1024;
  static constexpr std::uint32_t kNone = ~0U;
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t number = kNone;
  };

  /// Where the key is, or belongs.
  std::size_t Find(std::uint64_t key) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = KeySlot(key, mask);
    while (slots_[slot].number != kNone && slots_[slot].key != key) slot = (slot + 1) & mask;
    return slot;
  }
  void Grow() {
    slots_.assign(4 * slots_.size(), {});
    for (std::uint32_t n = 0; n < keys_.size(); ++n) slots_[Find(keys_[n])] = {keys_[n], n};
  }

  std::vector<Slot> slots_;
  std::vector<std::uint64_t> keys_;
};

/// The cells that one station sees.
struct StationCells {
  std::vector<std::uint64_t> keys;        // numbered by their first cluster
  std::vector<std::uint32_t> of_cluster;  // numbers
};

StationCells CellsOf(const ClusterList& clusters, const RigidTransform& pose,
                     const VoxelLattice& lattice) {
  StationCells cells;
  cells.of_cluster.resize(clusters.size());
  KeyNumbers numbers;
  std::uint64_t last_key = 0;
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    const std::uint64_t key = lattice.Key(pose * clusters.Mean(i));
    if (i == 0 || key != last_key) {  // clusters come by their voxels: many follow one of their own
      last_key = key;
      last = numbers.Number(key);
    }
    cells.of_cluster[i] = last;
  }
  cells.keys = numbers.keys();
  return cells;
}

constexpr std::uint32_t kAlone = ~0U;

/// The cells of two or more stations, ascending; and for each station its cells' places among them,
/// kAlone where no other station sees a cell.
std::vector<std::uint64_t> FindCommon(std::span<const StationCells> stations,
                                      std::vector<std::vector<std::uint32_t>>* places) {
  KeyNumbers numbers;
  std::vector<std::uint32_t> seen;  // by how many stations, then the cell's place
  for (std::size_t s = 0; s < stations.size(); ++s) {
    for (const std::uint64_t key : stations[s].keys) {
      const std::uint32_t number = numbers.Number(key);
      if (number == seen.size()) seen.push_back(0);
      ++seen[number];
      (*places)[s].push_back(number);
    }
  }
  std::vector<std::uint32_t> common;
  for (std::uint32_t n = 0; n < seen.size(); ++n) {
    if (seen[n] >= 2) common.push_back(n);
  }
  const std::vector<std::uint64_t>& all = numbers.keys();
  std::sort(common.begin(), common.end(),
            [&](std::uint32_t a, std::uint32_t b) { return all[a] < all[b]; });
  std::fill(seen.begin(), seen.end(), kAlone);
  std::vector<std::uint64_t> keys;
  for (const std::uint32_t n : common) {
    seen[n] = static_cast<std::uint32_t>(keys.size());
    keys.push_back(all[n]);
  }
  for (auto& of_station : *places) {
    for (std::uint32_t& place : of_station) place = seen[place];
  }
  return keys;
}

}  // namespace

CommonCells FindCommonCells(std::span<const ClusterList> clusters,
                            std::span<const RigidTransform> poses, const VoxelLattice& lattice,
                            const ExecutionContext* context) {
  std::vector<StationCells> stations(clusters.size());
  ForEach(context, clusters.size(),
          [&](std::size_t s) { stations[s] = CellsOf(clusters[s], poses[s], lattice); });
  std::vector<std::vector<std::uint32_t>> places(clusters.size());
  CommonCells cells;
  cells.keys = FindCommon(stations, &places);

  std::vector<std::size_t> next(cells.keys.size() + 1, 0);
  for (std::size_t s = 0; s < stations.size(); ++s) {
    for (const std::uint32_t cell : stations[s].of_cluster) {
      if (places[s][cell] != kAlone) ++next[places[s][cell] + 1];
    }
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  cells.begins = next;
  cells.entries.resize(next.back());
  for (std::size_t s = 0; s < stations.size(); ++s) {
    for (std::uint32_t i = 0; i < stations[s].of_cluster.size(); ++i) {
      const std::uint32_t place = places[s][stations[s].of_cluster[i]];
      if (place == kAlone) continue;
      cells.entries[next[place]++] = {static_cast<std::uint32_t>(s), i};
    }
    stations[s] = {};
  }
  return cells;
}

}  // namespace backsight
