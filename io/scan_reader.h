#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/point_chunk.h"
#include "core/rigid_transform.h"
#include "io/text_columns.h"

namespace backsight {

/// What a scan file says of itself, from its header alone.
struct ScanInfo {
  std::string path;
  std::string format;  ///< "E57", "LAS 1.4", "PCD", "PLY", "PTS", "PTX", "XYZ"
  int scan_index = 0;  ///< which scan of the file this is, from 0
  int scan_count = 1;  ///< how many scans the file holds
  std::optional<std::uint64_t> point_count;  ///< declared number of points; none for XYZ text
  bool has_intensity = false;
  bool has_rgb = false;
  bool rgb_16_bit = false;  ///< colours may take more than 8 bits per channel
  bool has_classification = false;
  bool has_gps_time = false;
  /// Scan grid; 0: unstructured, otherwise points come with their row and column.
  int rows = 0;
  int columns = 0;
  std::string guid;  ///< the file's identifier of the scan (E57), else empty
  std::string name;  ///< the file's name for the scan (E57), else empty
  /// Pose the file itself states for the scan (PTX header, PCD viewpoint, E57 pose); recorded, not
  /// applied.
  std::optional<RigidTransform> world_from_scan;
  std::string crs;                 ///< reference system the file states, WKT or "GeoTIFF: ..."
  std::vector<std::string> notes;  ///< repairs and guesses made while reading the header
};

/// What happened to the records of a scan while it was read.
struct ScanTally {
  std::uint64_t records = 0;       ///< read from the file
  std::uint64_t points = 0;        ///< handed out
  std::uint64_t not_finite = 0;    ///< dropped: NaN or infinite coordinate
  std::uint64_t no_return = 0;     ///< dropped: (0,0,0) in a scan grid, or marked as invalid
  std::uint64_t withheld = 0;      ///< dropped: flagged in the file as deleted (LAS "withheld")
  std::vector<std::string> notes;  ///< repairs and guesses made while reading the records
};

/// A run of records on its way from a file to points. Readers derive from it what they need.
struct ScanBlock {
  virtual ~ScanBlock() = default;
  PointChunk points;
};

/// Streams one scan in chunks; memory does not depend on the file's size. Coordinates are metres in
/// the scanner's own frame (station frame). All functions throw InputError with file and line or
/// byte offset for damaged input.
class ScanReader {
 public:
  virtual ~ScanReader() = default;
  virtual const ScanInfo& info() const = 0;
  /// Replaces `chunk` by the next run of points (at most about 16384 records' worth); false at the
  /// end. A true answer may carry an empty chunk where all its records were dropped.
  virtual bool Next(PointChunk& chunk) = 0;
  /// Of what Next, or Deliver, has handed out so far.
  virtual const ScanTally& tally() const = 0;

  /// Next in three steps, for StreamScan: Fetch takes the next records from the file, in order,
  /// false at the end; Parse makes their points, side by side with other blocks; Deliver counts
  /// them, in order again. Of one scan either these are called or Next. Unless a reader knows
  /// better, Fetch does it all.
  virtual std::unique_ptr<ScanBlock> NewBlock() const { return std::make_unique<ScanBlock>(); }
  virtual bool Fetch(ScanBlock& block) { return Next(block.points); }
  virtual void Parse(ScanBlock& /*block*/) const {}
  virtual void Deliver(ScanBlock& /*block*/) {}
};

/// Opens scan `scan_index` of the file; the format is known by the file's content first, its
/// extension second. Throws InputError for a missing, empty or unknown file (LAZ, COPC: named
/// as such, with what to convert them with), and for `columns` that are given though TakesColumns
/// is false. `between`, called now and then where opening takes long (PTX), may throw to give up.
std::unique_ptr<ScanReader> OpenScan(const std::string& path, int scan_index = 0,
                                     const TextColumns& columns = {},
                                     const std::function<void()>& between = {});

/// True for text (XYZ, PTS), whose columns have no meaning of their own. Throws as OpenScan.
bool TakesColumns(const std::string& path);

}  // namespace backsight
