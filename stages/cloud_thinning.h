#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/execution.h"
#include "core/voxel_grid.h"
#include "io/external_sort.h"

namespace backsight {

/// Relative uncertainty of a point that was measured at `range_m`, in metres:
///
///     range / max(cos(incidence), 0.2)
///
/// Footprint and point spacing grow with the range, and both, as the noise along the beam, with the
/// slant of the surface; the floor is that of the simulator's noise (RangeSigma). A point whose
/// surface is unknown counts as one of cosine 0.5, the mean over surfaces of all directions.
double PointUncertainty(double range_m, const std::optional<double>& cos_incidence);

/// A point among those that a cloud may hold.
struct PointPlace {
  std::size_t station = 0;  ///< below 65536, index in the order in which stations are written
  std::uint64_t index = 0;  ///< among the station's usable points, as they are read; below 2^48
};

/// Where a selection keeps what it works with.
struct ThinningSpace {
  std::string path;  ///< scratch files lie in its folder, without a name of their own
  std::size_t memory_bytes = std::size_t{64} << 20U;
};

/// Chooses of all points in a cell of the lattice the one of least uncertainty; among equals (as
/// float) that of the first station, of its points the first. Works on the disk: however many
/// points and cells there are, it needs no more memory than given, and on disk 24 bytes per point
/// and 8 per cell (24 per point more beyond 256 sorted runs), less where a cell's points come
/// together. Use: Offer every point, Choose, then ask Takes for every point in the order of their
/// places. Throws InputError for an unwritable place or a full disk.
class CloudThinning {
 public:
  CloudThinning(const VoxelLattice& lattice, const ThinningSpace& space);

  /// `point` is in the frame of the lattice and within it.
  void Offer(const PointPlace& place, const Eigen::Vector3d& point, double uncertainty);
  void Choose(const ExecutionContext& context);
  /// True once for each cell. Places must ascend by station, then index.
  bool Takes(const PointPlace& place);

 private:
  struct Candidate {
    std::uint64_t cell = 0;
    std::uint64_t place = 0;
    float uncertainty = 0.0F;

    friend bool operator<(const Candidate& a, const Candidate& b) {
      if (a.cell != b.cell) return a.cell < b.cell;
      if (a.uncertainty != b.uncertainty) return a.uncertainty < b.uncertainty;
      return a.place < b.place;
    }
  };
  struct CellOf {
    std::uint64_t operator()(const Candidate& candidate) const { return candidate.cell; }
  };
  struct Itself {
    std::uint64_t operator()(std::uint64_t place) const { return place; }
  };

  VoxelLattice lattice_;
  std::vector<Candidate> recent_;  // by hash of the cell: neighbours are often scanned together
  std::optional<ExternalSorter<Candidate, CellOf>> candidates_;  // until the choice is made
  ExternalSorter<std::uint64_t, Itself> chosen_;
  std::optional<std::uint64_t> next_;  // place of the next point to be taken
};

}  // namespace backsight
