#include "core/error.h"

#include <fmt/format.h>

namespace backsight {
namespace {

std::string Compose(const InputError::Details& d) {
  std::string text = d.where;
  if (!d.found.empty()) text += (text.empty() ? "" : ": ") + d.found;
  if (!d.expected.empty()) text += "; expected " + d.expected;
  if (!d.remedy.empty()) text += "; " + d.remedy;
  return text;
}

}  // namespace

InputError::InputError(Details details)
    : std::runtime_error(Compose(details)), details_(std::move(details)) {}

void FailCheck(std::string_view condition, std::string_view file, int line,
               std::string_view message) {
  throw InternalError(
      fmt::format("internal error at {}:{}: {} ({})", file, line, message, condition));
}

}  // namespace backsight
