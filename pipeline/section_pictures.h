#pragma once

#include <vector>

#include "core/execution.h"
#include "io/picture_record.h"
#include "pipeline/placed_clouds.h"
#include "pipeline/section_choice.h"

namespace backsight {

/// Each section as a whole, then its detail; of one chosen for its detail that alone.
std::vector<PictureRecord> DrawSections(const PlacedClouds& clouds,
                                        const std::vector<NamedSection>& sections,
                                        const ExecutionContext& context);

}  // namespace backsight
