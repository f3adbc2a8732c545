#include "io/output_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>
#include <string_view>

#include "io/run_records.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

std::string WithSuffix(const std::string& path, const std::string& suffix) {
  const fs::path p(path);
  return (p.parent_path() / (p.stem().string() + suffix + p.extension().string())).string();
}

/// Takes `prefix` and a number within [min, max] off the front of `text`, if they are there.
void TakeNumber(std::string_view prefix, int min, int max, std::string_view* text) {
  if (!text->starts_with(prefix)) return;
  const std::string_view digits = text->substr(prefix.size());
  int number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || digits.starts_with('0') || number < min || number > max) return;
  text->remove_prefix(prefix.size() + static_cast<std::size_t>(end - digits.data()));
}

}  // namespace

std::string ComponentPath(const std::string& path, int component) {
  if (component == 0) return path;
  return WithSuffix(path, fmt::format("_component{}", ComponentNumber(component)));
}

std::string PartPath(const std::string& path, std::size_t number) {
  return WithSuffix(path, fmt::format("-{}", number));
}

std::string AbsolutePath(const std::string& path) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error);
  return (error ? fs::path(path) : absolute).lexically_normal().string();
}

std::string FileKey(const std::string& path) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error).lexically_normal();
  if (error) return path;
  const fs::path folder = fs::weakly_canonical(absolute.parent_path(), error);
  return error ? absolute.string() : (folder / absolute.filename()).string();
}

int MostComponents(std::size_t stations) {
  return static_cast<int>(std::max<std::size_t>(1, stations / 2));
}

bool MayWrite(const CloudOutput& output, int components, const std::string& file) {
  const fs::path mine(FileKey(output.path));
  const fs::path other(FileKey(file));
  if (mine.parent_path() != other.parent_path() || mine.extension() != other.extension()) {
    return false;
  }
  const std::string stem = other.stem().string();
  const std::string begin = mine.stem().string();
  std::string_view rest = stem;
  if (!rest.starts_with(begin)) return false;
  rest.remove_prefix(begin.size());
  TakeNumber("_component", ComponentNumber(1), components, &rest);
  if (output.max_points > 0) TakeNumber("-", 1, std::numeric_limits<int>::max(), &rest);
  return rest.empty();
}

/// What can follow a name is a component, a part, or both. So where two names with something behind
/// them are the same, one of the two by itself is the other with something behind it.
bool MayCollide(const CloudOutput& a, const CloudOutput& b, int components) {
  return MayWrite(a, components, b.path) || MayWrite(b, components, a.path);
}

}  // namespace backsight
