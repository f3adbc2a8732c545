#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/rigid_transform.h"
#include "io/e57/e57_field.h"
#include "io/e57/paged_file.h"
#include "io/e57/vector_section.h"

namespace backsight {

/// What the XML section of an E57 file says of one scan (ASTM E2807, clause 8.4.3, "Data3D").
struct E57Scan {
  int scan_count = 0;  ///< scans in the file
  std::string guid;
  std::string name;
  std::string crs;  ///< what the file says of the frame that poses lead to, mostly WKT
  /// Identity where the file states none: the scan is then in the file's frame.
  RigidTransform world_from_scan;
  int rows = 0;  ///< of the scan grid, 0 for none
  int columns = 0;
  std::int64_t first_row = 0;  ///< number of the grid's first row
  std::int64_t first_column = 0;
  std::optional<E57Limits> intensity_limits;
  std::array<std::optional<E57Limits>, 3> color_limits;  ///< red, green, blue
  E57VectorPlace points;
  std::vector<E57Field> fields;    ///< of a point record, in the order of the bytestreams
  std::vector<std::string> notes;  ///< repairs
};

/// Reads scan `scan_index` from the XML section. Throws InputError for XML that is damaged or
/// beyond 32 MB, or a scan that is not there; other scans, images and extensions are not looked at.
/// Memory: some ten times the XML section, until it returns.
E57Scan ReadE57Scan(PagedFile& file, int scan_index);

}  // namespace backsight
