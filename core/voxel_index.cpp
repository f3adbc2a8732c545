#include "core/voxel_index.h"

#include <algorithm>
#include <bit>
#include <cmath>

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

/// std::popcount is a call where the processor's own instruction is not presumed.
std::uint32_t CountBits(std::uint64_t bits) {
  bits -= bits >> 1U & 0x5555555555555555U;
  bits = (bits & 0x3333333333333333U) + (bits >> 2U & 0x3333333333333333U);
  bits = (bits + (bits >> 4U)) & 0x0F0F0F0F0F0F0F0FU;
  return static_cast<std::uint32_t>(bits * 0x0101010101010101U >> 56U);
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
  order_.reserve(places.size());
  for (const Place& place : places) {
    if (brick_keys.empty() || brick_keys.back() != place.brick) {
      brick_keys.push_back(place.brick);
      bricks_.emplace_back();
    }
    const std::size_t x = place.within >> 6U;
    std::uint64_t& mask = bricks_.back().masks[x];
    if (mask == 0) bricks_.back().first[x] = static_cast<std::uint32_t>(order_.size());
    mask |= 1ULL << (place.within & 63U);
    order_.push_back(place.voxel);
  }

  slots_.resize(std::bit_ceil(2 * brick_keys.size() + 1));
  slot_mask_ = slots_.size() - 1;
  for (std::size_t i = 0; i < brick_keys.size(); ++i) {
    std::size_t slot = Slot(brick_keys[i]);
    while (slots_[slot].brick != kNoBrick) slot = (slot + 1) & slot_mask_;
    slots_[slot] = {brick_keys[i], static_cast<std::uint32_t>(i)};
  }
}

/// One search of the nearest point and the second nearest's distance: cell by cell from the query's
/// own, leaving out what lies farther than these. Lengths in cells.
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
  static constexpr double kRounding = 1e-9;  // means may lie beside their cells by rounding

  /// Of a coordinate from a cell.
  static double Gap(double place, int cell) {
    return std::max({cell - place, place - cell - 1.0, 0.0}) - kRounding;
  }
  double Bound() const { return best_.others_squared_m2 * per_square_; }

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
        const std::uint64_t rows = Run(y_first - 8 * in_y, y_last - 8 * in_y, 8);
        const std::uint64_t row = Run(z_first - 8 * in_z, z_last - 8 * in_z, 1) & 0xFFU;
        VisitCells(*brick, x & 7, rows & (row * 0x0101010101010101U));
      }
    }
  }

  /// The bits from place `first` to place `last`, cut to 0 .. 7, each place `width` bits.
  static std::uint64_t Run(int first, int last, int width) {
    const int from = width * std::max(first, 0);
    const int beyond = width * (7 - std::min(last, 7));
    return (~std::uint64_t{0} << from) & (~std::uint64_t{0} >> (64 - 8 * width + beyond));
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
  return Search(*this, points, query, radius_m).Run();
}

}  // namespace backsight
