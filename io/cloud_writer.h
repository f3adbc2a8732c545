#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/point_chunk.h"

namespace backsight {

/// What a writer must know before the first point.
struct CloudWriterSpec {
  std::string path;
  bool has_intensity = false;
  bool has_rgb = false;
  bool has_classification = false;                ///< PLY, PCD; LAS points always have a class
  Eigen::Vector3d min = Eigen::Vector3d::Zero();  ///< bounds that hold all points to come, metres
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
  double scale_m = 0.0001;  ///< LAS coordinate step
  std::string generator;    ///< "backsight 0.1.0"
  std::string wkt;          ///< LAS: reference system as OGC WKT, at most 65534 bytes; empty: none
  /// LAS: a cloud of more points goes into numbered files, see WrittenFiles; 0: never.
  std::uint64_t max_points_per_file = 0;
  /// Called now and then while Finish reads a file again; may throw to give up.
  std::function<void()> between = {};
};

struct WrittenFile {
  std::string path;
  std::uint64_t points = 0;
};

/// The files that hold a cloud of `points` points: spec.path itself, or where that would exceed
/// spec.max_points_per_file NAME-1.las, NAME-2.las and so on, all full but the last.
std::vector<WrittenFile> WrittenFiles(const CloudWriterSpec& spec, std::uint64_t points);

/// Writes a merged cloud as a stream. The file appears under its name only when Finish() has
/// returned (temporary file beside it, fsync, read again from end to end, rename); a writer
/// destroyed before that removes its temporary file. Throws InputError for an unwritable place, a
/// full disk, or a point that the format cannot hold. Attributes that a chunk lacks become 0; GPS
/// time is in LAS only.
class CloudWriter {
 public:
  virtual ~CloudWriter() = default;
  /// `station_number` (1..65535) becomes the LAS Point Source ID, PLY property or PCD field
  /// `station`.
  virtual void Write(const PointChunk& chunk, int station_number) = 0;
  /// Returns the number of points written.
  virtual std::uint64_t Finish() = 0;
};

/// Throws InputError for a number that 16 bits cannot hold or that is 0.
void RequireStationNumber(const std::string& path, int station_number);

/// LAS 1.4, point format 6, or 7 with colour. Before anything is written it is checked that the
/// bounds fit into 32 bit steps of `scale_m`; before a file gets its name it is read again from end
/// to end, and must have the count, bounds and reference system that were written (VerifyLas).
std::unique_ptr<CloudWriter> CreateLasWriter(const CloudWriterSpec& spec);
/// PCD 0.7, binary: coordinates as double, because float cannot hold those of a reference system.
/// Count and bounds are compared when it is read again (RequireWritten).
std::unique_ptr<CloudWriter> CreatePcdWriter(const CloudWriterSpec& spec);
/// PLY, binary little endian, coordinates as double; compared as PCD.
std::unique_ptr<CloudWriter> CreatePlyWriter(const CloudWriterSpec& spec);

}  // namespace backsight
