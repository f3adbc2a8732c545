#pragma once

#include <memory>
#include <string>
#include <vector>

namespace backsight {

/// A geoid model in a file of GeographicLib (16 bit PGM), the second source of heights beside the
/// grids of PROJ. Files are looked for where GeographicLib does: GEOGRAPHICLIB_GEOID_PATH, or
/// geoids/ in GEOGRAPHICLIB_DATA, or its own data folder. Not safe for use by several threads.
class VerticalGeoid {
 public:
  /// Names of the files that hold the geoid of a vertical CRS ("EPSG:3855"), finest grid first;
  /// empty for others than EGM84, EGM96 and EGM2008. Heights are above the ellipsoid of WGS 84.
  static std::vector<std::string> FilesFor(const std::string& vertical);
  /// The folder where they are looked for.
  static std::string Folder();
  /// The first of these files that is installed; null if none is. Throws InputError for a damaged
  /// one.
  static std::unique_ptr<VerticalGeoid> Open(const std::string& vertical);

  ~VerticalGeoid();

  /// Of the geoid above the ellipsoid, metres, by cubic interpolation; degrees. Throws InputError
  /// where the file cannot be read.
  double HeightAt(double latitude, double longitude) const;
  /// "egm2008-1.pgm"
  const std::string& file_name() const { return file_name_; }

 private:
  struct Model;
  VerticalGeoid(const std::string& folder, std::string file_name);

  std::string file_name_;
  std::string path_;
  std::unique_ptr<Model> model_;
};

}  // namespace backsight
