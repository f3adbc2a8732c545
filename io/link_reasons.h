#pragma once

#include <string_view>

namespace backsight {

/// What a reason code of links.csv means, in the words of a surveyor, e.g. for "ambiguous"; empty
/// for texts that are no such code.
std::string_view MeaningOfReason(std::string_view code);

}  // namespace backsight
