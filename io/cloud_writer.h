#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>

#include "core/point_chunk.h"

namespace backsight {

/// What a writer must know before the first point.
struct CloudWriterSpec {
  std::string path;
  bool has_intensity = false;
  bool has_rgb = false;
  Eigen::Vector3d min = Eigen::Vector3d::Zero();  ///< bounds that hold all points to come, metres
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
  double scale_m = 0.0001;  ///< LAS coordinate step
  std::string generator;    ///< "backsight 0.1.0"
};

/// Writes a merged cloud as a stream. The file appears under its name only when Finish() has
/// returned (temporary file beside it, fsync, rename); a writer destroyed before that removes its
/// temporary file. Throws InputError for an unwritable place, a full disk, or a point that the
/// format cannot hold.
class CloudWriter {
 public:
  virtual ~CloudWriter() = default;
  /// `station_number` (1..65535) becomes the LAS Point Source ID / PLY property `station`.
  virtual void Write(const PointChunk& chunk, int station_number) = 0;
  /// Returns the number of points written.
  virtual std::uint64_t Finish() = 0;
};

std::unique_ptr<CloudWriter> CreateLasWriter(const CloudWriterSpec& spec);
std::unique_ptr<CloudWriter> CreatePlyWriter(const CloudWriterSpec& spec);

}  // namespace backsight
