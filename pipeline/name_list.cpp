#include "pipeline/name_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace backsight {

std::string FirstNames(std::span<const std::string> names, std::size_t most) {
  const auto first = names.first(std::min(most, names.size()));
  return fmt::format("{}{}", fmt::join(first, ", "), names.size() > most ? " and others" : "");
}

}  // namespace backsight
