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

VoxelIndex::VoxelIndex(const VoxelLattice& lattice, std::span<const std::uint64_t> keys)
    : lattice_(lattice) {
  std::vector<Place> places;
  places.reserve(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) places.push_back(PlaceOf(keys[i], i));
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
    std::size_t slot = Slot(keys[i]);
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

/// One search of the nearest point and, if wanted, the second nearest's distance: cell by cell from
/// the query's own, leaving out what lies farther than these. Lengths in cells.
template <bool kOthers>
class VoxelIndex::Search {
 public:
  Search(const VoxelIndex& index, std::span<const Eigen::Vector3d> points,
         const Eigen::Vector3d& query, double radius_m)
      : index_(index),
        points_(points),
        query_(query),
        place_((query - index.lattice_.origin) / index.lattice_.edge_m),
        cell_(place_.array().floor().cast<int>()),
        per_square_(1.0 / (index.lattice_.edge_m * index.lattice_.edge_m)) {
    best_.squared_m2 = best_.others_squared_m2 = radius_m * radius_m;
    reach_ = static_cast<int>(std::ceil(radius_m / index.lattice_.edge_m));
  }

  std::optional<Neighbor> Run() {
    const int x = cell_.x();
    const int y = cell_.y();
    if (const Brick* own = Cached({x >> 3, y >> 3, cell_.z() >> 3}); own != nullptr) {
      VisitCells(*own, x & 7, std::uint64_t{1} << (8 * (y & 7) + (cell_.z() & 7)));
    }
    for (int dx = 0; dx <= reach_; ++dx) {
      for (const int sx : {x + dx, x - dx}) {
        const double in_x = Gap(place_.x(), sx);
        if (in_x * in_x > Bound()) continue;
        VisitSlice(sx, in_x * in_x);
        if (dx == 0) break;
      }
    }
    return found_ ? std::optional(best_) : std::nullopt;
  }

 private:
  /// Of a coordinate from a cell.
  static double Gap(double place, int cell) {
    return std::max({cell - place, place - cell - 1.0, 0.0}) - kRounding;
  }
  double Bound() const {
    return (kOthers ? best_.others_squared_m2 : best_.squared_m2) * per_square_;
  }

  /// The cells of a slice across x that are within the bound in y and in z.
  void VisitSlice(int x, double in_x2) {
    const double rest = Bound() - in_x2;
    if (rest < 0.0) return;
    const double reach = std::sqrt(rest) + kRounding;
    const int y_first = FloorOf(place_.y() - reach);
    const int y_last = FloorOf(place_.y() + reach);
    const int z_first = FloorOf(place_.z() - reach);
    const int z_last = FloorOf(place_.z() + reach);
    for (int in_y = y_first >> 3; in_y <= y_last >> 3; ++in_y) {
      for (int in_z = z_first >> 3; in_z <= z_last >> 3; ++in_z) {
        const Brick* brick = Cached({x >> 3, in_y, in_z});
        if (brick == nullptr) continue;
        VisitCells(
            *brick, x & 7,
            Window(y_first - 8 * in_y, y_last - 8 * in_y, z_first - 8 * in_z, z_last - 8 * in_z));
      }
    }
  }

  static int FloorOf(double value) {
    const int cut = static_cast<int>(value);
    return cut > value ? cut - 1 : cut;
  }

  void VisitCells(const Brick& brick, int x, std::uint64_t wanted) {
    const std::uint64_t mask = brick.masks[static_cast<std::size_t>(x)];
    const std::uint32_t* voxels = index_.order_.data() + brick.first[static_cast<std::size_t>(x)];
    for (std::uint64_t bits = mask & wanted; bits != 0; bits &= bits - 1) {
      const std::uint64_t lowest = bits & (~bits + 1U);
      Offer(voxels[CountBits(mask & (lowest - 1U))]);
    }
  }

  void Offer(std::uint32_t voxel) {
    const double squared = (query_ - points_[voxel]).squaredNorm();
    if (found_ && voxel == best_.voxel) return;  // the query's own cell comes twice
    const bool closer = squared < best_.squared_m2 ||
                        (squared == best_.squared_m2 && (!found_ || voxel < best_.voxel));
    if (closer) {
      if (found_) best_.others_squared_m2 = best_.squared_m2;
      best_.voxel = voxel;
      best_.squared_m2 = squared;
      found_ = true;
    } else {
      best_.others_squared_m2 = std::min(best_.others_squared_m2, squared);
    }
  }

  /// The bricks around the query, up to two along each axis, are each looked up once.
  const Brick* Cached(const Eigen::Vector3i& brick) {
    const auto slot =
        static_cast<std::size_t>((brick.x() & 1) << 2 | (brick.y() & 1) << 1 | (brick.z() & 1));
    Place& place = bricks_[slot];
    if (!place.asked || brick != place.at) place = {true, brick, index_.BrickAt(brick)};
    return place.brick;
  }

  const VoxelIndex& index_;
  std::span<const Eigen::Vector3d> points_;
  Eigen::Vector3d query_;
  Eigen::Vector3d place_;  // of the query, cells
  Eigen::Vector3i cell_;
  double per_square_;
  int reach_ = 0;
  Neighbor best_;
  bool found_ = false;
  struct Place {
    bool asked = false;
    Eigen::Vector3i at = Eigen::Vector3i::Zero();
    const Brick* brick = nullptr;
  };
  std::array<Place, 8> bricks_{};
};

std::optional<VoxelIndex::Neighbor> VoxelIndex::Nearest(std::span<const Eigen::Vector3d> points,
                                                        const Eigen::Vector3d& query,
                                                        double radius_m) const {
  if (!lattice_.Contains(query)) return std::nullopt;
  return Search<true>(*this, points, query, radius_m).Run();
}

std::optional<std::uint32_t> VoxelIndex::NearestVoxel(std::span<const Eigen::Vector3d> points,
                                                      const Eigen::Vector3d& query,
                                                      double radius_m) const {
  if (!lattice_.Contains(query)) return std::nullopt;
  const auto nearest = Search<false>(*this, points, query, radius_m).Run();
  return nearest ? std::optional(nearest->voxel) : std::nullopt;
}

}  // namespace backsight
