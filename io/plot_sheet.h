#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace backsight {

/// Where plan positions come to lie on a drawing, to scale, y upwards; with room for labels around
/// and for a scale bar below. Pixels; the width is always the same.
class PlotSheet {
 public:
  /// All that the drawing must hold, at least one; metres.
  explicit PlotSheet(const std::vector<Eigen::Vector2d>& positions);

  static constexpr double kWidth = 960.0;
  double height() const { return height_; }
  double pixels_per_m() const { return pixels_per_m_; }
  Eigen::Vector2d OnSheet(const Eigen::Vector2d& position) const;

  /// <svg ...> of a drawing that says `label` to those who cannot see it.
  std::string Open(const std::string& label) const;
  /// Axes with their names, scale bar, </svg>.
  std::string Close(const std::string& across, const std::string& up) const;

  /// The largest 1, 2 or 5 times a power of ten by which lengths (metres, not negative) may be
  /// exaggerated so that half of them are no longer than a mark, and none is very long; 0 if all
  /// are zero.
  double Exaggeration(std::vector<double> lengths_m) const;

 private:
  Eigen::Vector2d middle_m_ = Eigen::Vector2d::Zero();
  double pixels_per_m_ = 1.0;
  double height_ = 0.0;
};

/// Chooses places for labels beside marks, so that they cover neither marks nor each other as far
/// as there is room.
class LabelPlacer {
 public:
  /// `marks`: where labels should not lie; `font_px`: of the labels.
  LabelPlacer(const PlotSheet& sheet, const std::vector<Eigen::Vector2d>& marks, double font_px);

  /// A <text> beside the mark. `text` is not escaped yet.
  std::string Label(const Eigen::Vector2d& mark, const std::string& text);

 private:
  struct Box {
    Eigen::Vector2d min, max;
    double Overlap(const Box& other) const;
  };
  double width_, height_, font_px_;
  std::vector<Box> taken_;
};

/// The largest 1, 2 or 5 times a power of ten that is at most `longest`, which is above 0.
double RoundLength(double longest);

/// A scale bar of at most `longest_px`, its right end at (right, y).
std::string ScaleBarSvg(double right, double y, double pixels_per_m, double longest_px);

}  // namespace backsight
