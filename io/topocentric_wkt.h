#pragma once

#include <Eigen/Core>
#include <string>

namespace backsight {

/// Reference system of coordinates in a GeodeticFrame, as OGC WKT 2 (an engineering CRS: a frame
/// tied to a place is no projected system). `crs_name` is the system it belongs to, `origin` as
/// GeodeticFrame::origin: latitude and longitude in degrees, ellipsoidal height in metres.
std::string TopocentricWkt(const std::string& crs_name, const Eigen::Vector3d& origin);

}  // namespace backsight
