#include "graph/plane_segmentation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>

#include "core/voxel_grid.h"

namespace backsight {
namespace {

/// A voxel cluster with its station, moved to the world.
struct Item {
  int station = 0;
  const PointCluster* local = nullptr;
  PointCluster world;
};

/// The finaliser of SplitMix64 (Steele et al. 2014, doi 10.1145/2660193.2660195).
std::uint64_t Mix(std::uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31U);
}

struct Fit {
  Eigen::Vector3d eigenvalues;  // of the covariance, ascending, m^2
  Eigen::Vector3d normal;
};

Fit FitPlane(const PointCluster& cluster) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(cluster.Covariance());
  return {solver.eigenvalues(), solver.eigenvectors().col(0)};
}

/// What one station has in a cell.
struct StationPart {
  int station = 0;
  int clusters = 0;
  PointCluster world = {};
};

class Splitter {
 public:
  Splitter(const PlaneSearchOptions& options, std::vector<PlaneAssociation>* planes)
      : options_(options), planes_(planes) {}

  /// `items` lie in the cube with this centre and edge, ascending station.
  void Split(std::span<Item> items, const Eigen::Vector3d& center, double edge, int depth) {
    std::vector<StationPart> parts = GatherParts(items);
    std::erase_if(parts, [&](const StationPart& part) { return !HasEnough(part); });
    if (parts.size() < 2 || Accept(parts, items, PlaneCell(center, options_.root_edge_m, depth)) ||
        depth == options_.max_depth) {
      return;
    }

    const std::array<std::size_t, 9> begins = SortByOctant(items, center);
    for (std::size_t o = 0; o < 8; ++o) {
      if (begins[o] == begins[o + 1]) continue;
      const Eigen::Vector3d sign((o & 4U) != 0 ? 1 : -1, (o & 2U) != 0 ? 1 : -1,
                                 (o & 1U) != 0 ? 1 : -1);
      Split(items.subspan(begins[o], begins[o + 1] - begins[o]), center + 0.25 * edge * sign,
            0.5 * edge, depth + 1);
    }
  }

 private:
  /// Where each octant begins, and the end. Within an octant the order stays.
  std::array<std::size_t, 9> SortByOctant(std::span<Item> items, const Eigen::Vector3d& center) {
    const auto octant = [&](const Item& item) {
      const Eigen::Vector3d d = item.world.mean - center;
      return (d.x() >= 0.0 ? 4U : 0U) + (d.y() >= 0.0 ? 2U : 0U) + (d.z() >= 0.0 ? 1U : 0U);
    };
    std::array<std::size_t, 9> begins{};
    for (const Item& item : items) ++begins[octant(item) + 1];
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    std::array<std::size_t, 9> next = begins;
    scratch_.assign(items.begin(), items.end());
    for (const Item& item : scratch_) items[next[octant(item)]++] = item;
    return begins;
  }

  bool HasEnough(const StationPart& part) const {
    return part.world.count >= options_.min_points || part.clusters >= options_.min_clusters;
  }

  static std::vector<StationPart> GatherParts(std::span<const Item> items) {
    std::vector<StationPart> parts;
    for (const Item& item : items) {
      if (parts.empty() || parts.back().station != item.station) {
        parts.push_back({.station = item.station});
      }
      ++parts.back().clusters;
      parts.back().world += item.world;
    }
    return parts;
  }

  static PointCluster LocalSum(std::span<const Item> items, int station) {
    PointCluster sum;
    for (const Item& item : items) {
      if (item.station == station) sum += *item.local;
    }
    return sum;
  }

  bool IsPlanar(const Fit& fit) const {
    const Eigen::Vector3d& e = fit.eigenvalues;
    return e[0] < options_.max_thinness * e[1] && e[1] > options_.min_width * e[2] &&
           std::sqrt(std::max(e[0], 0.0)) < options_.max_thickness_m;
  }

  /// How far a station is from the joint plane, in units of what is allowed; below 1 it agrees.
  double Disagreement(const StationPart& part, const PointCluster& joint, const Fit& fit) const {
    const double cosine = std::abs(FitPlane(part.world).normal.dot(fit.normal));
    const Eigen::Vector3d offset = part.world.mean - joint.mean;
    const double across = offset.dot(fit.normal);
    const double along = (offset - across * fit.normal).norm();
    return std::max({std::acos(std::min(cosine, 1.0)) / options_.max_angle_rad,
                     std::abs(across) / options_.max_offset_m,
                     along / (2.0 * std::sqrt(fit.eigenvalues[2]))});
  }

  /// Records the plane if at least two stations see one plane here and agree on it.
  bool Accept(std::vector<StationPart> parts, std::span<const Item> items, std::uint64_t cell) {
    std::erase_if(parts, [&](const StationPart& part) { return !IsPlanar(FitPlane(part.world)); });
    while (parts.size() >= 2) {
      PointCluster joint;
      for (const StationPart& part : parts) joint += part.world;
      const Fit fit = FitPlane(joint);
      std::vector<double> disagreement;
      disagreement.reserve(parts.size());
      for (const StationPart& part : parts) {
        disagreement.push_back(Disagreement(part, joint, fit));
      }
      // Only the worst goes: it may have pulled the joint plane away from the others.
      const auto worst = std::max_element(disagreement.begin(), disagreement.end());
      if (!(*worst < 1.0)) {
        parts.erase(parts.begin() + (worst - disagreement.begin()));
        continue;
      }
      PlaneAssociation plane;
      plane.cell = cell;
      for (const StationPart& part : parts) {
        plane.observations.push_back({part.station, LocalSum(items, part.station)});
      }
      planes_->push_back(std::move(plane));
      return true;
    }
    return false;
  }

  const PlaneSearchOptions& options_;
  std::vector<PlaneAssociation>* planes_;
  std::vector<Item> scratch_;
};

/// A cluster's place among all, as light as it can be: there may be hundreds of millions.
struct Entry {
  std::uint64_t root_key;
  std::uint32_t station;
  std::uint32_t cluster;
};

void ForEach(const ExecutionContext* context, std::size_t n,
             const std::function<void(std::size_t)>& body) {
  if (context != nullptr) {
    context->ParallelFor(n, body);
  } else {
    for (std::size_t i = 0; i < n; ++i) body(i);
  }
}

class Association {
 public:
  Association(std::span<const ClusterList> clusters, std::span<const RigidTransform> poses,
              const PlaneSearchOptions& options, const ExecutionContext* context)
      : clusters_(clusters),
        poses_(poses),
        options_(options),
        context_(context),
        lattice_{.edge_m = options.root_edge_m} {}

  std::vector<PlaneAssociation> Find() const {
    const std::vector<Entry> entries = CommonEntries(CommonCells());
    std::vector<std::size_t> cells;  // where each begins, and the end
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (i == 0 || entries[i].root_key != entries[i - 1].root_key) cells.push_back(i);
    }
    cells.push_back(entries.size());
    constexpr std::size_t kChunk = 256;  // cells; fixed, so that the order is
    const std::size_t chunks = (cells.size() - 1 + kChunk - 1) / kChunk;
    std::vector<std::vector<PlaneAssociation>> found(chunks);
    ForEach(context_, chunks, [&](std::size_t chunk) {
      const std::size_t end = std::min((chunk + 1) * kChunk, cells.size() - 1);
      for (std::size_t c = chunk * kChunk; c < end; ++c) {
        SearchCell(std::span(entries).subspan(cells[c], cells[c + 1] - cells[c]), &found[chunk]);
      }
    });
    std::vector<PlaneAssociation> planes;
    for (auto& part : found) std::move(part.begin(), part.end(), std::back_inserter(planes));
    return planes;
  }

 private:
  std::uint64_t RootKey(std::size_t station, std::size_t cluster) const {
    return lattice_.Key(poses_[station] * clusters_[station][cluster].mean);
  }

  /// Root cells that two or more stations see, ascending.
  std::vector<std::uint64_t> CommonCells() const {
    std::vector<std::vector<std::uint64_t>> of_station(clusters_.size());
    ForEach(context_, clusters_.size(), [&](std::size_t s) {
      std::vector<std::uint64_t>& keys = of_station[s];
      for (std::size_t i = 0; i < clusters_[s].size(); ++i) {
        const std::uint64_t key = RootKey(s, i);
        if (keys.empty() || keys.back() != key) keys.push_back(key);
      }
      std::sort(keys.begin(), keys.end());
      keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    });
    std::vector<std::uint64_t> all;
    for (const auto& keys : of_station) all.insert(all.end(), keys.begin(), keys.end());
    std::sort(all.begin(), all.end());
    std::vector<std::uint64_t> common;
    for (std::size_t i = 1; i < all.size(); ++i) {
      if (all[i] == all[i - 1] && (common.empty() || common.back() != all[i])) {
        common.push_back(all[i]);
      }
    }
    return common;
  }

  /// The clusters in common cells, cell by cell, by station and cluster.
  std::vector<Entry> CommonEntries(const std::vector<std::uint64_t>& common) const {
    struct Found {
      std::uint32_t cell;
      std::uint32_t cluster;
    };
    std::vector<std::vector<Found>> of_station(clusters_.size());
    ForEach(context_, clusters_.size(), [&](std::size_t s) {
      auto place = common.end();
      std::uint64_t last = 0;
      for (std::size_t i = 0; i < clusters_[s].size(); ++i) {
        const std::uint64_t key = RootKey(s, i);
        // Clusters come by their voxels, so that many follow one of their own cell.
        if (i == 0 || key != last) {
          last = key;
          place = std::lower_bound(common.begin(), common.end(), key);
        }
        if (place == common.end() || *place != key) continue;
        of_station[s].push_back(
            {static_cast<std::uint32_t>(place - common.begin()), static_cast<std::uint32_t>(i)});
      }
    });
    std::vector<std::size_t> next(common.size() + 1, 0);
    for (const auto& part : of_station) {
      for (const Found& found : part) ++next[found.cell + 1];
    }
    std::partial_sum(next.begin(), next.end(), next.begin());
    std::vector<Entry> entries(next.back());
    for (std::size_t s = 0; s < of_station.size(); ++s) {
      for (const Found& found : of_station[s]) {
        entries[next[found.cell]++] = {common[found.cell], static_cast<std::uint32_t>(s),
                                       found.cluster};
      }
      of_station[s] = {};
    }
    return entries;
  }

  void SearchCell(std::span<const Entry> cell, std::vector<PlaneAssociation>* planes) const {
    std::vector<Item> items;
    items.reserve(cell.size());
    for (const Entry& entry : cell) {
      const PointCluster& local = clusters_[entry.station][entry.cluster];
      const RigidTransform& pose = poses_[entry.station];
      items.push_back({static_cast<int>(entry.station), &local,
                       Transformed(pose.rotation, pose.translation, local)});
    }
    const Eigen::Vector3d corner = lattice_.Corner(VoxelLattice::Unpack(cell.front().root_key));
    const Eigen::Vector3d center = corner.array() + 0.5 * options_.root_edge_m;
    Splitter(options_, planes).Split(items, center, options_.root_edge_m, 0);
  }

  std::span<const ClusterList> clusters_;
  std::span<const RigidTransform> poses_;
  const PlaneSearchOptions& options_;
  const ExecutionContext* context_;
  VoxelLattice lattice_;
};

}  // namespace

std::uint64_t PlaneCell(const Eigen::Vector3d& world_point, double root_edge_m, int depth) {
  const VoxelLattice lattice{.edge_m = std::ldexp(root_edge_m, -depth)};
  constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15U;
  return Mix(lattice.Key(world_point) + kGolden * static_cast<std::uint64_t>(depth + 1));
}

std::vector<PlaneAssociation> FindPlanes(std::span<const ClusterList> clusters,
                                         std::span<const RigidTransform> poses,
                                         const PlaneSearchOptions& options,
                                         const ExecutionContext* context) {
  return Association(clusters, poses, options, context).Find();
}

std::vector<PlaneAssociation> FindPlanes(std::span<const std::vector<PointCluster>* const> clusters,
                                         std::span<const RigidTransform> poses,
                                         const PlaneSearchOptions& options) {
  std::vector<ClusterList> lists;
  lists.reserve(clusters.size());
  for (const std::vector<PointCluster>* list : clusters) lists.emplace_back(*list);
  return FindPlanes(lists, poses, options, nullptr);
}

}  // namespace backsight
