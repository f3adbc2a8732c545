#pragma once

#include <vector>

#include "core/option_visitor.h"
#include "io/strict_yaml.h"

namespace backsight {

/// Fills the fields behind `sections` from the maps of the same name in `root`. A missing section
/// or key keeps its default, and so does a section with nothing in it (all lines commented out).
/// Wrong types, values out of range and unknown keys join the document's violations.
void ReadOptions(const YamlValue& root, const std::vector<OptionSection>& sections);

}  // namespace backsight
