#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace backsight {

/// "8.2 s", "42 s", "5 min 03 s", "2 h 05 min".
std::string DurationText(double seconds);

/// Per second or, below one, per minute: "3.2/s", "14/min", "0.05/min".
std::string RateText(double per_second);

/// One line for people about a stage after `elapsed_s`, of which `done` of `total` units are
/// finished, `before` of them before it began: how many, how fast, for how long and, while it goes
/// on, for how long still, as if all units took the same time. A stage of one unit has no count and
/// no rate.
std::string ProgressText(std::string_view stage, std::size_t done, std::size_t total,
                         double elapsed_s, std::size_t before = 0);

/// The line of a stage that counts nothing.
std::string StageText(std::string_view stage, double elapsed_s);

}  // namespace backsight
