#pragma once

#include <span>
#include <string>
#include <string_view>

namespace backsight {

/// The candidate most like `name` (smallest Levenshtein distance, first of equals), or empty if
/// none is near enough to be a slip of the keyboard: at most 2 edits, or a third of the length.
std::string NearestName(std::string_view name, std::span<const std::string> candidates);

}  // namespace backsight
