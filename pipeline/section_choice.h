#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/picture_record.h"
#include "pipeline/placed_clouds.h"
#include "pipeline/section_drawing.h"
#include "stages/surface_distances.h"

namespace backsight {

inline constexpr double kThicknessM = 0.05;  ///< of all sections
inline constexpr double kDetailM = 2.0;      ///< wide
inline constexpr double kDetailHighM = 1.3;

/// A section with its name, and the detail in it.
struct NamedSection {
  Section section;
  std::string name;  ///< "A", if it stands upright
  bool upright = false;
  double at_m = 0.0;                      ///< a level's height
  double length_m = 0.0;                  ///< of an upright one's line within the plan, from zero
  std::optional<Eigen::Vector2d> detail;  ///< its middle on paper
  std::optional<double>
      apart_m;  ///< of the surfaces there; then it was chosen for the detail alone
};

/// Two levels and two upright sections, 5 cm thick, where most surface that several stations
/// measured is cut steeply: there a misalignment shows. Upright ones follow the walls. Details lie
/// where most of that is cut. `samples`: in the frame of the clouds; without any, sections go
/// through the middle and have no details.
std::vector<NamedSection> ChooseSections(const CloudExtent& extent,
                                         const std::vector<DistanceSample>& samples);

/// Through the place where surfaces of several stations lie furthest apart (median of the samples
/// in 0.5 m); none where samples are nowhere dense enough.
std::optional<NamedSection> ChooseWorst(const CloudExtent& extent,
                                        const std::vector<DistanceSample>& samples);

/// The sections' lines in plan, for the upright ones: all of it, or as long as the detail.
std::vector<PictureLine> TracesOf(const std::vector<NamedSection>& sections);

}  // namespace backsight
