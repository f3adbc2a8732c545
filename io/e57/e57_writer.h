#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/point_chunk.h"
#include "core/rigid_transform.h"
#include "io/e57/paged_writer.h"
#include "io/e57/vector_writer.h"
#include "io/read_back.h"

namespace backsight {

/// What identifies an E57 file. Nothing in the file depends on a clock or on chance but this.
struct E57FileSpec {
  std::string path;
  std::string guid;
  std::string generator;  ///< becomes e57LibraryVersion: "backsight 0.1.0"
  std::string crs;        ///< of the poses, as WKT; becomes coordinateMetadata; empty: local
  /// Seconds since 1980-01-06 00:00 UTC without leap seconds (GPS time); none: not stated.
  std::optional<double> creation_gps_s;
  /// Called now and then while Finish reads the file again; may throw to give up.
  std::function<void()> between = {};
};

/// How coordinates are stored.
enum class E57Coordinates {
  kDouble,
  kSingle,        ///< about 7 digits
  kScaledInteger  ///< multiples of scale_m, in as few bits as the bounds allow
};

/// What must be known of a scan before its first point.
struct E57ScanSpec {
  std::string guid;
  std::string name;
  RigidTransform world_from_scan;
  E57Coordinates coordinates = E57Coordinates::kDouble;
  double scale_m = 0.0001;                        ///< for scaled integers
  Eigen::Vector3d min = Eigen::Vector3d::Zero();  ///< for scaled integers: bounds of all points
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
  bool has_invalid_state = false;
  bool has_intensity = false;
  bool has_rgb = false;
  bool rgb_16_bit = false;  ///< else 8 bits per channel, which all software reads
  int rows = 0;             ///< scan grid; 0: the scan has none
  int columns = 0;
};

/// Writes scans as an E57 file (ASTM E2807), as a stream: BeginScan, Write, EndScan for each scan,
/// then Finish, which reads the file again (RequireWritten, checksums of all pages) before it
/// appears under its name. Equal calls give equal bytes. Coordinates are metres in the scan's own
/// frame. Throws InputError for an unwritable place, a full disk, or a point that the chosen
/// coordinates cannot hold. Memory: one packet of 64 KB, some kilobytes per scan.
class E57Writer {
 public:
  explicit E57Writer(E57FileSpec spec);

  void BeginScan(const E57ScanSpec& scan);
  /// `invalid_states`: 0 a point, 1 only a direction, 2 nothing; empty where the scan has none.
  void Write(const PointChunk& chunk, std::span<const std::uint8_t> invalid_states = {});
  /// Returns the number of records of the scan.
  std::uint64_t EndScan();
  void Finish();

 private:
  void AddFields();
  void AddCoordinateFields();
  std::int64_t Steps(double value_m, const E57Field& field) const;
  void RequireReadable() const;
  void WriteCoordinates(const Eigen::Vector3d& point, bool is_point);
  void WriteAttributes(const PointChunk& chunk, std::size_t i);

  E57FileSpec spec_;
  PagedWriter out_;
  E57ScanSpec scan_;
  std::vector<E57Field> fields_;
  std::optional<VectorWriter> points_;
  std::vector<CloudContent> written_;  // by scan; coordinates as they are stored
  std::string scans_xml_;
};

}  // namespace backsight
