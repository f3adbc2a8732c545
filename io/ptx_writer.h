#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "core/rigid_transform.h"
#include "io/atomic_file.h"

namespace backsight {

/// Writes PTX, one or more scans: BeginScan, then rows * columns records column by column (that is
/// the order of PTX: all rows of the first column, then the next), and Finish at the end. Points
/// are in the scanner's own frame, metres, written to the micrometre. Throws InputError for an
/// unwritable place or a full disk.
class PtxWriter {
 public:
  struct Scan {
    int columns = 0;
    int rows = 0;
    bool has_rgb = false;
    RigidTransform world_from_scan;
  };

  explicit PtxWriter(const std::string& path) : file_(path) {}

  void BeginScan(const Scan& scan);
  /// `intensity` 0 to 1. `rgb` is written only where the scan has colours.
  void AddPoint(const Eigen::Vector3d& point, double intensity,
                const std::array<std::uint8_t, 3>& rgb = {0, 0, 0});
  /// A grid cell whose pulse came back from nowhere.
  void AddNoReturn();
  /// The file appears under its name; all announced records must have been written.
  void Finish();

 private:
  void Count();

  AtomicFile file_;
  Scan scan_;
  std::uint64_t missing_ = 0;  // records that the current scan still needs
};

}  // namespace backsight
