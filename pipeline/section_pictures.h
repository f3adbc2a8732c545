#pragma once

#include <string>
#include <vector>

#include "io/picture_record.h"
#include "pipeline/placed_clouds.h"
#include "pipeline/section_drawing.h"
#include "stages/surface_distances.h"

namespace backsight {

/// A section with its name, its line in plan if it stands upright, and the detail in it.
struct NamedSection {
  Section section;
  std::string name;  ///< "A"
  bool upright = false;
  double at_m = 0.0;  ///< a level's height
};

/// Two levels and two upright sections, 5 cm thick, where most surface that several stations
/// measured is cut steeply: there a misalignment shows. Upright ones follow the walls. `samples`:
/// in the frame of the clouds; without any, sections go through the middle.
std::vector<NamedSection> ChooseSections(const CloudExtent& extent,
                                         const std::vector<DistanceSample>& samples);

/// The sections' lines in plan, for the upright ones.
std::vector<PictureLine> TracesOf(const std::vector<NamedSection>& sections,
                                  const CloudExtent& extent);

/// Each section as a whole, then around the place where most is cut that several stations measured.
std::vector<PictureRecord> DrawSections(const PlacedClouds& clouds,
                                        const std::vector<NamedSection>& sections,
                                        const std::vector<DistanceSample>& samples);

}  // namespace backsight
