#pragma once

#include <string>
#include <vector>

#include "core/option_visitor.h"

namespace backsight {

/// Every option of `sections` with its default (the value it holds now), unit, range and meaning.
/// The text is what `backsight options` prints, the Markdown is docs/options.md.
std::string OptionsAsText(const std::vector<OptionSection>& sections);
std::string OptionsAsMarkdown(const std::vector<OptionSection>& sections);

/// {"schema_version": 1, "sections": [{"name", "meaning", "options": [{"key", "type", "default",
/// "unit", "min", "max", "choices", "meaning"}]}]}; unit, min, max and choices only where the type
/// has them.
std::string OptionsAsJson(const std::vector<OptionSection>& sections);

}  // namespace backsight
