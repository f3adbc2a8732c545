#include "stages/aligned_hypotheses.h"

#include <algorithm>
#include <set>

#include "core/voxel_grid.h"
#include "stages/dominant_frame.h"

namespace backsight {
namespace {

/// A translation that a correspondence asks for.
struct Ballot {
  std::uint64_t cell = 0;
  std::uint32_t source = 0;
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

/// A cell of translations with its neighbours.
struct Tally {
  int voters = 0;  ///< distinct source key points
  std::uint64_t cell = 0;
  RigidTransform motion;
};

std::vector<Ballot> Collect(const Correspondences& c, const Eigen::Matrix3d& rotation,
                            const VoxelLattice& lattice) {
  std::vector<Ballot> ballots;
  ballots.reserve(c.size());
  for (std::size_t i = 0; i < c.size(); ++i) {
    const Eigen::Vector3d translation = c.target[i] - rotation * c.source[i];
    if (!lattice.Contains(translation)) continue;
    ballots.push_back({lattice.Key(translation), c.source_id[i], translation});
  }
  std::sort(ballots.begin(), ballots.end(), [](const Ballot& a, const Ballot& b) {
    return std::pair(a.cell, a.source) < std::pair(b.cell, b.source);
  });
  return ballots;
}

/// Counts the voters in a cell and the 26 around it.
Tally Count(const std::vector<Ballot>& ballots, std::uint64_t cell,
            const Eigen::Matrix3d& rotation) {
  const Eigen::Vector3i center = VoxelLattice::Unpack(cell);
  std::vector<std::uint32_t> voters;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (int i = 0; i < 27; ++i) {
    const std::uint64_t key =
        VoxelLattice::Pack(center + Eigen::Vector3i(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1));
    auto ballot =
        std::lower_bound(ballots.begin(), ballots.end(), key,
                         [](const Ballot& b, std::uint64_t value) { return b.cell < value; });
    for (; ballot != ballots.end() && ballot->cell == key; ++ballot) {
      voters.push_back(ballot->source);
      sum += ballot->translation;
      count += 1.0;
    }
  }
  std::sort(voters.begin(), voters.end());
  const auto distinct = std::unique(voters.begin(), voters.end()) - voters.begin();
  return {static_cast<int>(distinct), cell, {rotation, sum / count}};
}

}  // namespace

std::vector<Eigen::Matrix3d> AlignedRotations(const Surface& source, const Surface& target,
                                              bool levelled) {
  std::optional<Eigen::Vector3d> up;
  if (levelled) up = Eigen::Vector3d::UnitZ();
  const DominantFrame of_source = FindDominantFrame(source.normals, up);
  const DominantFrame of_target = FindDominantFrame(target.normals, up);
  constexpr double kFewestWalls = 0.3;
  std::vector<Eigen::Matrix3d> rotations;
  if (std::min(of_source.wall_share, of_target.wall_share) < kFewestWalls) return rotations;
  for (const Eigen::Matrix3d& turn : CubeTurns()) {
    if (levelled && turn(2, 2) < 0.5) continue;
    rotations.emplace_back(of_target.frame_from_cloud.transpose() * turn *
                           of_source.frame_from_cloud);
  }
  return rotations;
}

std::vector<RigidTransform> VoteForTranslations(const Correspondences& c,
                                                std::span<const Eigen::Matrix3d> rotations,
                                                double resolution_m, std::size_t count) {
  constexpr int kFewestVoters = 3;
  const VoxelLattice lattice{.edge_m = 2.0 * resolution_m};
  std::vector<Tally> tallies;
  for (const Eigen::Matrix3d& rotation : rotations) {
    const std::vector<Ballot> ballots = Collect(c, rotation, lattice);
    std::vector<Tally> own;
    for (std::size_t i = 0; i < ballots.size(); ++i) {
      if (i > 0 && ballots[i].cell == ballots[i - 1].cell) continue;
      Tally tally = Count(ballots, ballots[i].cell, rotation);
      if (tally.voters >= kFewestVoters) own.push_back(std::move(tally));
    }
    std::stable_sort(own.begin(), own.end(),
                     [](const Tally& a, const Tally& b) { return a.voters > b.voters; });
    std::set<std::uint64_t> taken;  // cells that a better one covers
    for (const Tally& tally : own) {
      if (taken.contains(tally.cell)) continue;
      tallies.push_back(tally);
      const Eigen::Vector3i center = VoxelLattice::Unpack(tally.cell);
      for (int i = 0; i < 27; ++i) {
        taken.insert(
            VoxelLattice::Pack(center + Eigen::Vector3i(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1)));
      }
    }
  }
  std::stable_sort(tallies.begin(), tallies.end(),
                   [](const Tally& a, const Tally& b) { return a.voters > b.voters; });
  std::vector<RigidTransform> motions;
  for (std::size_t i = 0; i < std::min(count, tallies.size()); ++i) {
    motions.push_back(tallies[i].motion);
  }
  return motions;
}

}  // namespace backsight
