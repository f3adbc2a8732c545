#include "io/topocentric_wkt.h"

#include <fmt/format.h>

namespace backsight {
namespace {

/// Quotes within WKT text are doubled.
std::string WktText(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted.append(c == '"' ? "\"\"" : std::string(1, c));
  return quoted + "\"";
}

}  // namespace

std::string TopocentricWkt(const std::string& crs_name, const Eigen::Vector3d& origin) {
  const std::string datum = fmt::format(
      "origin at latitude {:.10f} deg, longitude {:.10f} deg, ellipsoidal height {:.4f} m",
      origin.x(), origin.y(), origin.z());
  const std::string remark = fmt::format(
      "Cartesian coordinates in the local topocentric frame (east, north, up) at this origin, on "
      "the datum of {}; not coordinates of {}",
      crs_name, crs_name);
  return fmt::format(
      "ENGCRS[{},EDATUM[{}],CS[Cartesian,3],AXIS[\"east (E)\",east,ORDER[1]],"
      "AXIS[\"north (N)\",north,ORDER[2]],AXIS[\"up (U)\",up,ORDER[3]],"
      "LENGTHUNIT[\"metre\",1],REMARK[{}]]",
      WktText("Local topocentric frame of " + crs_name), WktText(datum), WktText(remark));
}

}  // namespace backsight
