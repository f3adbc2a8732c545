#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace backsight {

/// A colour and what it stands for.
struct PictureKey {
  std::string label;
  std::array<std::uint8_t, 3> rgb{};
};

/// A value of a colour scale; between two of them both value and colour run evenly.
struct PictureStop {
  double value = 0.0;
  std::array<std::uint8_t, 3> rgb{};
};

/// The colour scale of a picture of values.
struct PictureScale {
  std::string label;  ///< with the unit
  std::vector<PictureStop> stops;
  bool open_below = true;  ///< the first colour also stands for values below it
  bool open_above = true;  ///< the last colour also stands for values above it
};

/// A line drawn over a picture: where a section was cut. In the picture's metres.
struct PictureLine {
  std::string label;
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
};

/// A drawing of the cloud, to scale: pixels, and what a reader needs to measure in them.
struct PictureRecord {
  enum class Kind { kPlan, kSection, kDetail, kDistances };
  Kind kind = Kind::kPlan;
  std::string title;
  std::string caption;
  int width_px = 0;
  int height_px = 0;
  double metres_per_pixel = 0.0;
  Eigen::Vector2d left_top = Eigen::Vector2d::Zero();  ///< corner of the picture, metres
  std::string across;                                  ///< what grows to the right
  std::string up;                                      ///< what grows upwards
  std::vector<PictureKey> keys;
  std::optional<PictureScale> scale;
  std::vector<PictureLine> lines;
  std::string png_base64;
};

inline constexpr PictureRecord::Kind kPictureKinds[] = {
    PictureRecord::Kind::kPlan, PictureRecord::Kind::kSection, PictureRecord::Kind::kDetail,
    PictureRecord::Kind::kDistances};

std::string ToString(PictureRecord::Kind kind);

}  // namespace backsight
