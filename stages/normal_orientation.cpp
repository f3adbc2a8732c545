#include "stages/normal_orientation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <queue>
#include <unordered_map>

#include "core/neighbors.h"

namespace backsight {
namespace {

constexpr double kPatchEdge = 3.0;   // voxels
constexpr double kPatchReach = 6.0;  // voxels; patches within this are neighbours
constexpr double kCredible = 0.75;

/// A coarse piece of surface with an orientable normal.
struct Patch {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  int leaves = 0;
};

struct PatchSurface {
  std::vector<Patch> patches;
  std::vector<std::uint32_t> patch_of_leaf;
};

PatchSurface MakePatches(const StationModel& model) {
  const VoxelLattice lattice{.edge_m = kPatchEdge * model.resolution_m()};
  PatchSurface surface;
  std::unordered_map<std::uint64_t, std::uint32_t> slots;
  for (const VoxelLeaf& leaf : model.leaves) {
    const auto [slot, is_new] = slots.try_emplace(
        lattice.Key(leaf.cluster.mean), static_cast<std::uint32_t>(surface.patches.size()));
    if (is_new) surface.patches.emplace_back();
    Patch& patch = surface.patches[slot->second];
    patch.position += leaf.cluster.mean;
    ++patch.leaves;
    surface.patch_of_leaf.push_back(slot->second);
  }
  for (Patch& patch : surface.patches) patch.position /= patch.leaves;
  return surface;
}

std::vector<Eigen::Vector3d> Positions(const std::vector<Patch>& patches) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(patches.size());
  for (const Patch& patch : patches) positions.push_back(patch.position);
  return positions;
}

/// Normal of each patch from the patches around it; zero where there are too few.
void EstimateNormals(const NeighborSearch& search, double reach_m, std::vector<Patch>* patches) {
  constexpr std::size_t kFewest = 5;
  for (Patch& patch : *patches) {
    PointCluster cluster;
    const auto neighbors = search.Within(patch.position, reach_m);
    if (neighbors.size() < kFewest) continue;
    for (const auto& neighbor : neighbors) {
      const Patch& other = (*patches)[neighbor.index];
      cluster +=
          PointCluster{static_cast<double>(other.leaves), other.position, Eigen::Matrix3d::Zero()};
    }
    patch.normal =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(cluster.scatter).eigenvectors().col(0);
  }
}

/// Grows one connected part from `seed` along its smoothest connections, making signs agree.
std::vector<std::uint32_t> Propagate(const NeighborSearch& search, double reach_m,
                                     std::uint32_t seed, std::vector<char>* done,
                                     std::vector<Patch>* patches) {
  struct Step {
    double roughness;
    std::uint32_t from, to;
    bool operator<(const Step& other) const {  // the smoothest first; ties by index
      return roughness != other.roughness ? roughness > other.roughness : to > other.to;
    }
  };
  std::priority_queue<Step> queue;
  queue.push({0.0, seed, seed});
  std::vector<std::uint32_t> part;
  while (!queue.empty()) {
    const Step step = queue.top();
    queue.pop();
    if ((*done)[step.to] != 0) continue;
    (*done)[step.to] = 1;
    part.push_back(step.to);
    Patch& patch = (*patches)[step.to];
    if (patch.normal.dot((*patches)[step.from].normal) < 0.0) patch.normal = -patch.normal;
    for (const auto& neighbor : search.Within(patch.position, reach_m)) {
      const Patch& other = (*patches)[neighbor.index];
      if ((*done)[neighbor.index] != 0 || other.normal.isZero()) continue;
      queue.push({1.0 - std::abs(patch.normal.dot(other.normal)), step.to, neighbor.index});
    }
  }
  return part;
}

void OrientByContinuity(double reach_m, std::vector<Patch>* patches) {
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  for (const Patch& patch : *patches) {
    centroid += patch.position / static_cast<double>(patches->size());
  }
  const NeighborSearch search(Positions(*patches));
  EstimateNormals(search, reach_m, patches);
  std::vector<char> done(patches->size(), 0);
  for (std::uint32_t seed = 0; seed < patches->size(); ++seed) {
    if (done[seed] != 0 || (*patches)[seed].normal.isZero()) continue;
    const auto part = Propagate(search, reach_m, seed, &done, patches);
    int towards = 0;
    for (const std::uint32_t p : part) {
      const Patch& patch = (*patches)[p];
      towards += patch.normal.dot(centroid - patch.position) > 0.0 ? patch.leaves : -patch.leaves;
    }
    if (towards >= 0) continue;
    for (const std::uint32_t p : part) (*patches)[p].normal = -(*patches)[p].normal;
  }
}

/// Share of the patches, weighted by their leaves, whose normal looks at the scanner.
double AgreementWithScanner(const std::vector<Patch>& patches) {
  double agree = 0.0;
  double all = 0.0;
  for (const Patch& patch : patches) {
    if (patch.normal.isZero()) continue;
    all += patch.leaves;
    if (patch.normal.dot(-patch.position) > 0.0) agree += patch.leaves;
  }
  return all > 0.0 ? agree / all : 1.0;
}

}  // namespace

NormalOrientation OrientNormals(const StationModel& model, bool scanner_known,
                                std::vector<Eigen::Vector3f>* normals) {
  NormalOrientation result;
  PatchSurface surface;
  if (!scanner_known) {
    surface = MakePatches(model);
    OrientByContinuity(kPatchReach * model.resolution_m(), &surface.patches);
    result.agreement = AgreementWithScanner(surface.patches);
    result.scanner_credible = result.agreement >= kCredible;
  }
  for (std::size_t i = 0; i < normals->size(); ++i) {
    Eigen::Vector3f& normal = (*normals)[i];
    Eigen::Vector3f towards = (-model.leaves[i].cluster.mean).cast<float>();
    if (!result.scanner_credible) {
      const Patch& patch = surface.patches[surface.patch_of_leaf[i]];
      if (!patch.normal.isZero()) towards = patch.normal.cast<float>();
    }
    if (normal.dot(towards) < 0.0F) normal = -normal;
  }
  return result;
}

}  // namespace backsight
