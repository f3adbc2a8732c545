#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/e57/e57_field.h"
#include "io/e57/e57_writer.h"

namespace backsight {

/// Where the points of a scan went, and what their bounds are (low > high: there are no points).
struct E57Written {
  std::uint64_t file_offset = 0;  ///< physical
  std::uint64_t record_count = 0;
  Eigen::Vector3d low, high;
};

/// The "vectorChild" of data3D that describes a scan (ASTM E2807, clause 8.4.3).
std::string E57ScanXml(const E57ScanSpec& scan, const std::vector<E57Field>& fields,
                       const E57Written& written);

/// The whole XML section around the scans' elements (clause 8.4.2).
std::string E57RootXml(const E57FileSpec& file, std::string_view scans_xml);

}  // namespace backsight
