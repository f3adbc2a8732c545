#include "stages/normal_orientation.h"

#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <unordered_map>

#include "graph/symmetric_eigen.h"
#include "stages/leaf_grid.h"

namespace backsight {
namespace {

constexpr double kPatchEdge = 3.0;   // voxels
constexpr double kPatchReach = 6.0;  // voxels; patches within this are neighbours
constexpr double kLeastAgreement = 0.75;

/// A coarse piece of surface with an orientable normal.
struct Patch {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  int leaves = 0;
  std::vector<std::uint32_t> neighbors;  // itself among them
};

struct PatchSurface {
  std::vector<Patch> patches;
  std::vector<std::uint32_t> patch_of_leaf;
};

PatchSurface MakePatches(const StationModel& model) {
  const VoxelLattice lattice{.edge_m = kPatchEdge * model.resolution_m()};
  PatchSurface surface;
  std::unordered_map<std::uint64_t, std::uint32_t> slots;
  std::uint64_t last_key = ~std::uint64_t{0};
  std::uint32_t last_slot = 0;  // leaves of one patch often follow each other
  surface.patch_of_leaf.reserve(model.leaves.size());
  for (const Eigen::Vector3d& mean : model.leaves.means()) {
    const std::uint64_t key = lattice.Key(mean);
    if (key != last_key) {
      const auto next = static_cast<std::uint32_t>(surface.patches.size());
      const auto [slot, is_new] = slots.try_emplace(key, next);
      if (is_new) surface.patches.emplace_back();
      last_key = key;
      last_slot = slot->second;
    }
    Patch& patch = surface.patches[last_slot];
    patch.position += mean;
    ++patch.leaves;
    surface.patch_of_leaf.push_back(last_slot);
  }
  for (Patch& patch : surface.patches) patch.position /= patch.leaves;
  return surface;
}

std::vector<Eigen::Vector3f> Positions(const std::vector<Patch>& patches) {
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(patches.size());
  for (const Patch& patch : patches) positions.push_back(patch.position.cast<float>());
  return positions;
}

void FindNeighbors(const LeafGrid& grid, double reach_m, const ExecutionContext& context,
                   std::vector<Patch>* patches) {
  std::vector<std::uint32_t> indices(grid.size() + LeafGrid::kPadding);
  for (std::size_t place = 0; place < grid.size(); ++place) indices[place] = grid.LeafAt(place);
  grid.ForCells(context, [&](LeafGrid::Range cells) {
    BallSearch search(grid, reach_m);
    std::vector<std::uint32_t> candidates;
    for (std::uint32_t cell = cells.begin; cell < cells.end; ++cell) {
      search.EnterCell(cell);
      search.Gather(indices, 0U, &candidates);
      for (std::uint32_t place = grid.Cell(cell).begin; place < grid.Cell(cell).end; ++place) {
        const auto found = search.Around(place);
        auto& neighbors = (*patches)[grid.LeafAt(place)].neighbors;
        neighbors.reserve(found.size());
        for (const std::uint32_t j : found) neighbors.push_back(candidates[j]);
      }
    }
  });
}

/// Scatter of the patch's neighbours about their mean, weighted by their leaves: xx xy xz yy yz zz.
std::array<double, 6> ScatterAround(const Patch& patch, const std::vector<Patch>& patches) {
  double weight = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const std::uint32_t n : patch.neighbors) {
    const Patch& other = patches[n];
    const Eigen::Vector3d offset = other.position - patch.position;
    weight += other.leaves;
    first += other.leaves * offset;
    second += other.leaves * offset * offset.transpose();
  }
  const Eigen::Matrix3d m = second - first * first.transpose() / weight;
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

/// Normal of each patch from the patches around it; zero where there are too few.
void EstimateNormals(std::vector<Patch>* patches) {
  constexpr std::size_t kFewest = 5;
  SymmetricColumns scatters;
  scatters.Resize(patches->size());
  for (std::size_t i = 0; i < patches->size(); ++i) {
    scatters.Set(i, ScatterAround((*patches)[i], *patches));
  }
  const std::vector<Eigen::Vector3d> directions = LeastDirections(scatters);
  for (std::size_t i = 0; i < patches->size(); ++i) {
    if ((*patches)[i].neighbors.size() >= kFewest) (*patches)[i].normal = directions[i];
  }
}

/// Grows one connected part from `seed` along its smoothest connections, making signs agree.
/// `reached`: by patch, the least roughness of a connection to it so far.
std::vector<std::uint32_t> Propagate(std::uint32_t seed, std::vector<double>* reached,
                                     std::vector<char>* done, std::vector<Patch>* patches) {
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
    for (const std::uint32_t n : patch.neighbors) {
      const Patch& other = (*patches)[n];
      if ((*done)[n] != 0 || other.normal.isZero()) continue;
      const double roughness = 1.0 - std::abs(patch.normal.dot(other.normal));
      if (roughness >= (*reached)[n]) continue;
      (*reached)[n] = roughness;
      queue.push({roughness, step.to, n});
    }
  }
  return part;
}

void OrientByContinuity(double reach_m, const ExecutionContext& context,
                        std::vector<Patch>* patches) {
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  for (const Patch& patch : *patches) {
    centroid += patch.position / static_cast<double>(patches->size());
  }
  FindNeighbors(LeafGrid(Positions(*patches), reach_m / 2.0), reach_m, context, patches);
  EstimateNormals(patches);
  std::vector<double> reached(patches->size(), std::numeric_limits<double>::infinity());
  std::vector<char> done(patches->size(), 0);
  for (std::uint32_t seed = 0; seed < patches->size(); ++seed) {
    if (done[seed] != 0 || (*patches)[seed].normal.isZero()) continue;
    const auto part = Propagate(seed, &reached, &done, patches);
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

NormalOrientation OrientNormals(const StationModel& model, const ExecutionContext& context,
                                std::vector<Eigen::Vector3f>* normals) {
  NormalOrientation result;
  PatchSurface surface;
  if (model.scanner_place != ScannerPlace::kGiven) {
    surface = MakePatches(model);
    OrientByContinuity(kPatchReach * model.resolution_m(), context, &surface.patches);
    result.agreement = AgreementWithScanner(surface.patches);
    result.scanner_credible =
        model.scanner_place == ScannerPlace::kAssumed && result.agreement >= kLeastAgreement;
  }
  for (std::size_t i = 0; i < normals->size(); ++i) {
    Eigen::Vector3f& normal = (*normals)[i];
    Eigen::Vector3f towards = (-model.leaves.Mean(i)).cast<float>();
    if (!result.scanner_credible) {
      const Patch& patch = surface.patches[surface.patch_of_leaf[i]];
      if (!patch.normal.isZero()) towards = patch.normal.cast<float>();
    }
    if (normal.dot(towards) < 0.0F) normal = -normal;
  }
  return result;
}

}  // namespace backsight
