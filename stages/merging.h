#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/execution.h"
#include "core/rigid_transform.h"
#include "io/cloud_writer.h"
#include "io/scan_reader.h"
#include "io/survey_project.h"
#include "stages/cloud_thinning.h"

namespace backsight {

/// A placed station and how to read its scan again.
struct MergeStation {
  int number = 1;                     ///< Point Source ID, 1..65535
  RigidTransform frame_from_station;  ///< into the Cartesian frame that all stations share
  double scale = 1.0;                 ///< of the station's coordinates, before that
  Eigen::Vector3d range_origin =
      Eigen::Vector3d::Zero();                    ///< ranges count from here, station frame
  Eigen::Vector3d min = Eigen::Vector3d::Zero();  ///< bounds of the points used, station frame
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
  double min_range_m = 0.0;  ///< the range limits of the ingest hold here too
  double max_range_m = 0.0;
  bool has_intensity = false;
  bool has_rgb = false;
  std::function<std::unique_ptr<ScanReader>()> open;
  /// Throws InputError where the scan is no longer the one that the pose is of; empty: never looks.
  /// Called whenever the scan has been read.
  std::function<void()> require_unchanged;
  /// Cosine of the angle at which the beam met the surface at a point of the scan, station frame
  /// (SurfaceIncidence); empty: never known. Asked for in the order of reading, when thinning.
  std::function<std::optional<double>(const Eigen::Vector3d&)> cos_incidence;
  /// Whether a point of the scan, station frame, is of something that moved; empty: none is. Must
  /// be safe for several threads.
  std::function<bool(const Eigen::Vector3d&)> is_moving;
};

/// Class of points of things that moved: the first that the LAS standard leaves to its users
/// (LAS 1.4 R15, table 17).
inline constexpr std::uint8_t kMovingClass = 64;

/// Takes points from the shared frame to the coordinates of the output, in place; empty: they are
/// the same. Must be safe for several threads.
using OutputMap = std::function<void(std::span<Eigen::Vector3d>)>;

/// Which points of the stations a cloud holds, and in what coordinates.
struct MergeOptions {
  OutputMap map;
  double thin_m = 0.0;     ///< keep one point per cell of this edge of the shared frame; 0: all
  ThinningSpace thinning;  ///< used where thin_m > 0; beside the output
  std::optional<CropBox> crop;  ///< in output coordinates
  /// Leave out what moved; otherwise it gets kMovingClass, and stands for a cell only where nothing
  /// else does.
  bool without_moving = false;
  /// Points as they were scanned but for the scale, for files that state each station's pose.
  bool in_station_frames = false;
};

/// Bounds of all stations' points in output coordinates, from the corners of their boxes and a
/// metre more where the map bends them; never beyond the crop box.
struct CloudBounds {
  Eigen::Vector3d min;
  Eigen::Vector3d max;
};
CloudBounds MergedBounds(const std::vector<MergeStation>& stations, const MergeOptions& options);

/// Reads every station's scan once more and hands its points to `writer`; when thinning twice: of
/// each cell the point of least PointUncertainty is kept (CloudThinning). Streams: chunks are read
/// and written in their order, and worked on by all threads meanwhile; memory is constant for a
/// number of threads, when thinning that of options.thinning beside it. Returns the number of
/// points written; the caller finishes the writer. Throws InputError for a scan that has changed.
std::uint64_t MergeClouds(const std::vector<MergeStation>& stations, const MergeOptions& options,
                          CloudWriter& writer, const ExecutionContext& context);

}  // namespace backsight
