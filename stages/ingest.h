#pragma once

#include <optional>
#include <string>

#include "core/execution.h"
#include "core/option_visitor.h"
#include "io/scan_reader.h"
#include "stages/station_model.h"

namespace backsight {

struct IngestOptions {
  double resolution_m = 0.1;  ///< l, edge of the voxels
  double min_range_m = 0.5;   ///< nearer returns are the instrument and its operator
  double max_range_m = 1000.0;
  double range_image_deg = 0.25;
};
void VisitOptions(OptionVisitor& visitor, IngestOptions& options);

struct IngestResult {
  StationModel model;
  ScanTally tally;
  std::uint64_t out_of_range = 0;  ///< dropped: nearer or farther than allowed
  std::vector<std::string> notes;  ///< what the reader and this stage decided
};

/// Streams the scan once into voxel clusters and the scanner's range image. `scanner_origin` is the
/// instrument's position in the scan's coordinates, (0, 0, 0) where it is not given. Memory follows
/// the number of occupied voxels, not of points. Throws InputError where nothing usable is left.
IngestResult IngestScan(const std::string& station_id, ScanReader& reader,
                        const std::optional<Eigen::Vector3d>& scanner_origin,
                        const IngestOptions& options, const ExecutionContext& context);

}  // namespace backsight
