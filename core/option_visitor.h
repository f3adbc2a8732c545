#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace backsight {

/// Visits the fields of an options struct. Each struct lists every field once, in a function
/// `void VisitOptions(OptionVisitor&, XOptions&)` beside it; YAML reading, validation,
/// `backsight options`, docs/options.md and fingerprints all come from that one list.
/// `unit` is "m", "deg", "1" (a ratio or count) or the like; `min` and `max` are inclusive.
class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;
  virtual void Real(std::string_view key, double& value, std::string_view unit, double min,
                    double max, std::string_view meaning) = 0;
  virtual void Integer(std::string_view key, int& value, std::string_view unit, int min, int max,
                       std::string_view meaning) = 0;
  virtual void Flag(std::string_view key, bool& value, std::string_view meaning) = 0;
  /// `value` is an index into `names`.
  virtual void Choice(std::string_view key, int& value, const std::vector<std::string>& names,
                      std::string_view meaning) = 0;
};

/// A named section of the project file, e.g. {"registration", visit}.
struct OptionSection {
  std::string name;
  std::string meaning;
  std::function<void(OptionVisitor&)> visit;
};

/// "key=value" lines of all fields in their order, values with full precision: the canonical text
/// for fingerprints and manifests.
std::string CanonicalText(const OptionSection& section);

}  // namespace backsight
