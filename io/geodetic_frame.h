#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "core/error.h"

namespace backsight {

/// The way between a projected coordinate reference system and a local topocentric frame: CRS ->
/// geographic coordinates and ellipsoidal height of the same datum (PROJ) -> geocentric -> east,
/// north, up about an origin (GeographicLib). Grid distances are not ground distances, so that
/// nothing rigid may be fitted in the CRS itself. Not safe for use by several threads at once.
class GeodeticFrame {
 public:
  /// `horizontal`: any projected CRS that PROJ knows ("EPSG:25832"); `vertical`: of its heights, or
  /// empty: heights are ellipsoidal. They lead to the ellipsoid by a grid of PROJ, or where that
  /// is not installed by a VerticalGeoid. Throws InputError, `where` in it, for an unknown name, a
  /// CRS of another kind or not in metres, heights for which neither is installed (the files are
  /// named), and heights that can be had through another datum only: none is ever guessed.
  GeodeticFrame(const std::string& horizontal, const std::string& vertical,
                const std::string& where);
  ~GeodeticFrame();
  GeodeticFrame(GeodeticFrame&&) noexcept;
  GeodeticFrame& operator=(GeodeticFrame&&) noexcept;

  /// What speaks against a place with these coordinates, for an error message: the CRS does not
  /// reach there, or it lies more than 3 degrees outside the area that PROJ's database says the CRS
  /// is used in. Nothing if it is well, or no area is known. Needs no origin.
  std::optional<InputError::Details> FaultOf(const Eigen::Vector3d& crs) const;

  /// Easting, northing and height of the origin, in metres and this order whatever the order of
  /// the CRS's axes. Throws InputError where the CRS does not reach.
  void SetOrigin(const Eigen::Vector3d& crs);

  /// Throw InputError for a place that cannot be converted. They undo each other within 0.01 mm.
  Eigen::Vector3d EnuFromCrs(const Eigen::Vector3d& crs) const;
  Eigen::Vector3d CrsFromEnu(const Eigen::Vector3d& enu) const;

  /// Columns: where easting, northing and height grow, as orthonormal directions in enu.
  Eigen::Matrix3d AxesAt(const Eigen::Vector3d& crs) const;

  /// Convergence (of grid north against true north, clockwise positive) and point scale (grid over
  /// ellipsoid) at the origin.
  double convergence_deg() const;
  double point_scale() const;

  const std::string& name() const;     ///< "ETRS89 / UTM zone 32N + DHHN2016 height"
  const std::string& wkt() const;      ///< OGC WKT 1, for LAS
  const std::string& heights() const;  ///< what heights are and by which grid
  /// Latitude and longitude in degrees, ellipsoidal height in metres.
  const Eigen::Vector3d& origin() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace backsight
