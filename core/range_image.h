#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

namespace backsight {

/// Spherical image of what a scanner saw: nearest and farthest range per direction. Rows run over
/// polar angle (z axis of the station frame up), columns over azimuth. Metres; 0 where nothing was
/// measured.
class RangeImage {
 public:
  RangeImage() = default;
  /// `origin`: the scanner's position in the station frame. Memory: 8 bytes per pixel.
  RangeImage(const Eigen::Vector3d& origin, double pixel_deg);

  void Add(const Eigen::Vector3d& point);
  /// Takes over what another image of the same origin and pixels has measured.
  void Add(const RangeImage& other);

  struct Pixel {
    float min_m = 0.0F;
    float max_m = 0.0F;
  };
  /// The pixel in whose direction `point` lies.
  const Pixel& At(const Eigen::Vector3d& point) const { return pixels_[Index(point)]; }

  /// What was measured in the pixel of a direction and those around it.
  struct Window {
    float nearest_m = 0.0F;   ///< 0: nothing was measured
    float farthest_m = 0.0F;  ///< likewise
    float gap_m = 0.0F;  ///< from the point's range to the closest end of a pixel's ranges, >= 0
    Pixel middle;        ///< the one in whose direction the point lies
  };
  /// Three by three pixels about `point`; where pixels are narrow, near the poles, as many columns
  /// as make up the same angle. Time O(9), at the poles O(columns).
  Window Around(const Eigen::Vector3d& point) const;

  /// Row and column of the pixel in whose direction `point` lies.
  std::pair<int, int> PixelOf(const Eigen::Vector3d& point) const { return Cell(point - origin_); }

  const Eigen::Vector3d& origin() const { return origin_; }
  int rows() const { return rows_; }
  int columns() const { return columns_; }
  /// Edge of a pixel, radians.
  double PixelAngle() const;
  /// Share of directions, by solid angle, in which something was measured, 0 to 1.
  double Coverage() const;
  /// Pixels in which something was measured.
  std::size_t Measured() const;

 private:
  std::size_t Index(int row, int column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  /// Row and column of the direction from the origin to a point.
  std::pair<int, int> Cell(const Eigen::Vector3d& direction) const;
  /// Takes `count` neighbouring pixels into the window of a point at `range`.
  static void Include(const Pixel* pixels, int count, float range, Window* window);
  std::size_t Index(const Eigen::Vector3d& point) const;

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  int rows_ = 0;
  int columns_ = 0;
  std::vector<int> reach_;  // per row: columns either way that make up a pixel's angle
  std::vector<Pixel> pixels_;
};

}  // namespace backsight
