#include "pipeline/progress_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace backsight {

std::string DurationText(double seconds) {
  if (seconds < 9.95) return fmt::format("{:.1f} s", std::max(seconds, 0.0));
  const auto whole = std::llround(seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

std::string RateText(double per_second) {
  const bool slow = per_second < 1.0;
  const double rate = slow ? 60.0 * per_second : per_second;
  const int digits = rate >= 10.0 ? 0 : rate >= 1.0 ? 1 : 2;
  return fmt::format("{:.{}f}/{}", rate, digits, slow ? "min" : "s");
}

std::string ProgressText(std::string_view stage, std::size_t done, std::size_t total,
                         double elapsed_s, std::size_t before) {
  if (total <= 1) return StageText(stage, elapsed_s);
  const double per_second = elapsed_s > 0.0 ? static_cast<double>(done - before) / elapsed_s : 0.0;
  std::string text =
      fmt::format("{:<14} {:>5} of {:<5} {:>8}  {}", stage, done, total,
                  per_second > 0.0 ? RateText(per_second) : "", DurationText(elapsed_s));
  if (per_second > 0.0 && done < total) {
    text += ", about " + DurationText(static_cast<double>(total - done) / per_second) + " left";
  }
  return text;
}

std::string StageText(std::string_view stage, double elapsed_s) {
  return fmt::format("{:<14} {:>24}{}", stage, "", DurationText(elapsed_s));
}

}  // namespace backsight
