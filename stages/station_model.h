#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/range_image.h"
#include "core/rigid_transform.h"
#include "core/voxel_leaves.h"

namespace backsight {

/// What is known of where the scanner stood.
enum class ScannerPlace : char {
  kAssumed,  ///< at the scan's origin, because nobody says otherwise; surfaces may contradict it
  kGiven,    ///< the user vouches for it
  kUnknown,  ///< proved not to be where it was assumed
};

/// What is kept of a scan after its one streaming pass. All geometry (features, planes, overlap) is
/// computed from the voxel clusters, over all raw points but for rounding (VoxelPoints,
/// VoxelSpread).
///
/// Frames: clusters are kept in the `instrument` frame, which has the station frame's axes and its
/// origin at the instrument, so that coordinates stay small and rotations are decoupled from
/// translations even where a scan comes in large coordinates. Usually both frames are the same.
struct StationModel {
  std::string id;
  Eigen::Vector3d scanner_origin = Eigen::Vector3d::Zero();  ///< instrument, station frame, metres
  ScannerPlace scanner_place = ScannerPlace::kAssumed;       ///< how far scanner_origin counts
  /// Sorted by key; the cluster's mean is the representative point. Instrument frame.
  VoxelLeaves leaves;
  RangeImage range_image;                         ///< instrument frame
  Eigen::Vector3d min = Eigen::Vector3d::Zero();  ///< bounds of all raw points, station frame
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
  std::uint64_t points = 0;

  const VoxelLattice& lattice() const { return leaves.lattice(); }
  double resolution_m() const { return lattice().edge_m; }  ///< l
  RigidTransform StationFromInstrument() const {
    return {Eigen::Matrix3d::Identity(), scanner_origin};
  }
};

/// What a scanner at the origin saw of the leaves: of pixels as large as `pixel_deg`.
RangeImage ImageOf(const VoxelLeaves& leaves, double pixel_deg);

/// Fast point feature histogram: three blocks of 11 bins, each block sums to 100.
using FpfhDescriptor = std::array<float, 33>;

/// Local geometry of a station's leaves; index i is leaf i.
struct StationFeatures {
  std::vector<Eigen::Vector3f> normals;     ///< unit, towards the scanner; NaN where undefined
  std::vector<std::uint32_t> keypoints;     ///< leaf indices, ascending
  std::vector<FpfhDescriptor> descriptors;  ///< one per key point
  bool scanner_credible = true;             ///< false: the scan is not in its scanner's frame
};

}  // namespace backsight
