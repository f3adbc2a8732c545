#include "core/voxel_index.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace backsight {
namespace {

struct Place {
  std::uint64_t brick;
  std::uint32_t within;  // x, y, z, three bits each
  std::uint32_t voxel;
};

Place PlaceOf(std::uint64_t key, std::size_t voxel) {
  const Eigen::Vector3i cell = VoxelLattice::Unpack(key);
  return {VoxelLattice::Pack({cell.x() >> 3, cell.y() >> 3, cell.z() >> 3}),
          static_cast<std::uint32_t>((cell.x() & 7) << 6 | (cell.y() & 7) << 3 | (cell.z() & 7)),
          static_cast<std::uint32_t>(voxel)};
}

/// The step to the brick beyond a face: below and above along x, y and z.
Eigen::Vector3i Beyond(int face) {
  const Eigen::Vector3i step = Eigen::Vector3i::Unit(face / 2);
  return face % 2 == 0 ? Eigen::Vector3i(-step) : step;
}

/// The faces of its brick that a cell lies at, a bit for each.
unsigned FacesOf(std::uint32_t within) {
  unsigned faces = 0;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const std::uint32_t place = within >> (6U - 3U * axis) & 7U;
    if (place == 0U) faces |= 1U << (2U * axis);
    if (place == 7U) faces |= 2U << (2U * axis);
  }
  return faces;
}

}  // namespace

VoxelIndex::VoxelIndex(const VoxelPoints& points) : lattice_(points.lattice()) {
  std::vector<Place> places;
  places.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) places.push_back(PlaceOf(points.Key(i), i));
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return a.brick != b.brick ? a.brick < b.brick : a.within < b.within;
  });

  std::vector<std::uint64_t> brick_keys;
  std::vector<std::uint64_t> beside;  // bricks that a voxel shares a face with
  for (std::size_t begin = 0, end = 0; begin < places.size(); begin = end) {
    unsigned faces = 0;
    for (; end < places.size() && places[end].brick == places[begin].brick; ++end) {
      faces |= FacesOf(places[end].within);
    }
    brick_keys.push_back(places[begin].brick);
    const Eigen::Vector3i at = VoxelLattice::Unpack(places[begin].brick);
    for (int face = 0; face < 6; ++face) {
      if ((faces >> face & 1U) != 0U) beside.push_back(VoxelLattice::Pack(at + Beyond(face)));
    }
  }
  beside.insert(beside.end(), brick_keys.begin(), brick_keys.end());
  MakeBricks(std::move(beside));
  order_.reserve(places.size());
  Brick* brick = nullptr;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i == 0 || places[i].brick != places[i - 1].brick) {
      brick = BrickAt(VoxelLattice::Unpack(places[i].brick));
    }
    const std::size_t x = places[i].within >> 6U;
    std::uint64_t& mask = brick->masks[x];
    if (mask == 0) brick->first[x] = static_cast<std::uint32_t>(order_.size());
    mask |= 1ULL << (places[i].within & 63U);
    order_.push_back(places[i].voxel);
  }
  for (const std::uint64_t key : brick_keys) {
    const Eigen::Vector3i at = VoxelLattice::Unpack(key);
    MarkNear(*BrickAt(at), at);
  }
}

/// Bricks of these keys, each once.
void VoxelIndex::MakeBricks(std::vector<std::uint64_t> keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  bricks_.resize(keys.size());
  slots_.resize(std::bit_ceil(2 * keys.size() + 1));
  slot_mask_ = slots_.size() - 1;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    std::size_t slot = KeySlot(keys[i], slot_mask_);
    while (slots_[slot].brick != kNoBrick) slot = (slot + 1) & slot_mask_;
    slots_[slot] = {keys[i], static_cast<std::uint32_t>(i)};
  }
}

/// Marks the cells of the brick's voxels and those that share a face with them.
void VoxelIndex::MarkNear(const Brick& brick, const Eigen::Vector3i& at) {
  constexpr std::uint64_t kFirstZ = 0x0101010101010101U;
  constexpr std::uint64_t kLastZ = kFirstZ << 7U;
  Brick& own = *BrickAt(at);
  // Marks what a mask says where it says anything: only then there is a brick.
  const auto mark = [&](int face, std::size_t x, std::uint64_t mask) {
    if (mask != 0) BrickAt(at + Beyond(face))->near[x] |= mask;
  };
  for (std::size_t x = 0; x < kEdge; ++x) {
    const std::uint64_t mask = brick.masks[x];
    own.near[x] |=
        mask | mask << 8U | mask >> 8U | (mask & ~kLastZ) << 1U | (mask & ~kFirstZ) >> 1U;
    if (x > 0) own.near[x - 1] |= mask;
    if (x + 1 < kEdge) own.near[x + 1] |= mask;
    mark(2, x, mask << 56U);
    mark(3, x, mask >> 56U);
    mark(4, x, (mask & kFirstZ) << 7U);
    mark(5, x, (mask & kLastZ) >> 7U);
  }
  mark(0, kEdge - 1, brick.masks[0]);
  mark(1, 0, brick.masks[kEdge - 1]);
}

/// One search of the nearest point: in the query's cell and the 26 around it, then, if what lies
/// beyond them may be nearer, as far as that. Lengths in cells where not said otherwise.
class VoxelIndex::Search {
 public:
  Search(const VoxelIndex& index, const VoxelPoints& points, const Eigen::Vector3d& query,
         double radius_m)
      : index_(index),
        points_(points),
        query_(query),
        place_((query - index.lattice_.origin) / index.lattice_.edge_m),
        cell_(FloorOf(place_.x()), FloorOf(place_.y()), FloorOf(place_.z())),
        distance_(points, cell_, place_ - cell_.cast<double>()) {
    best_ = {kNone, radius_m * radius_m, radius_m * radius_m};
  }

  std::optional<Neighbor> Run() {
    VisitNextCells();
    const double clear_m = index_.lattice_.edge_m * ToNextCellsEdge();
    if (best_.squared_m2 >= clear_m * clear_m) {
      VisitBeyond();
    } else {
      best_.others_squared_m2 = std::min(best_.others_squared_m2, clear_m * clear_m);
    }
    return best_.voxel != kNone ? std::optional(best_) : std::nullopt;
  }

 private:
  static constexpr std::uint32_t kNone = ~0U;

  /// Nothing outside the 27 cells is closer than this.
  double ToNextCellsEdge() const {
    const Eigen::Array3d in_cell = place_.array() - cell_.cast<double>().array();
    return 1.0 + in_cell.min(1.0 - in_cell).minCoeff() - kRounding;
  }

  void VisitNextCells() {
    for (int by = (cell_.y() - 1) >> 3; by <= (cell_.y() + 1) >> 3; ++by) {
      for (int bz = (cell_.z() - 1) >> 3; bz <= (cell_.z() + 1) >> 3; ++bz) {
        const int y = cell_.y() - kEdge * by;
        const int z = cell_.z() - kEdge * bz;
        const std::uint64_t wanted = Window(y - 1, y + 1, z - 1, z + 1);
        for (int bx = (cell_.x() - 1) >> 3; bx <= (cell_.x() + 1) >> 3; ++bx) {
          const Brick* brick = index_.BrickAt({bx, by, bz});
          if (brick == nullptr) continue;
          const int last = std::min(cell_.x() + 1 - kEdge * bx, kEdge - 1);
          for (int x = std::max(cell_.x() - 1 - kEdge * bx, 0); x <= last; ++x) {
            index_.VisitBits(*brick, x, wanted, [&](std::uint32_t voxel, int bit) {
              Offer(voxel, distance_.Squared(CellOf({bx, by, bz}, x, bit), voxel));
            });
          }
        }
      }
    }
  }

  void VisitBeyond() {
    constexpr double kInclusive = 1.0 + 1e-12;
    const double reach_m = std::sqrt(best_.others_squared_m2) * kInclusive;
    index_.VisitWithin(points_, query_, reach_m, [&](std::uint32_t voxel, double squared_m2) {
      if (voxel != best_.voxel) Offer(voxel, squared_m2);
    });
  }

  /// Without branches, which nobody could foretell.
  void Offer(std::uint32_t voxel, double squared_m2) {
    const bool tied = squared_m2 == best_.squared_m2 && voxel < best_.voxel;
    const bool closer = squared_m2 < best_.squared_m2 || tied;
    best_.others_squared_m2 =
        std::min(best_.others_squared_m2, std::max(squared_m2, best_.squared_m2));
    best_.squared_m2 = std::min(best_.squared_m2, squared_m2);
    best_.voxel = closer ? voxel : best_.voxel;
  }

  const VoxelIndex& index_;
  const VoxelPoints& points_;
  Eigen::Vector3d query_;
  Eigen::Vector3d place_;  // of the query
  Eigen::Vector3i cell_;
  VoxelPoints::DistanceFrom distance_;
  Neighbor best_;
};

std::optional<VoxelIndex::Neighbor> VoxelIndex::Nearest(const VoxelPoints& points,
                                                        const Eigen::Vector3d& query,
                                                        double radius_m) const {
  if (!lattice_.Contains(query)) return std::nullopt;
  return Search(*this, points, query, radius_m).Run();
}

}  // namespace backsight
