#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "io/nearest_name.h"
#include "io/strict_yaml.h"
#include "io/text_file.h"
#include "io/utf8.h"
#include "io/yaml_tree.h"

namespace backsight {
namespace {

using yaml_internal::Node;

constexpr std::uintmax_t kMaxBytes = 16U << 20U;

/// The parser guesses other encodings and skips what it cannot decode; we would rather say so.
void CheckEncoding(const std::string& text, const std::string& name) {
  int line = 1;
  std::size_t line_begin = 0;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = Utf8Length(text, i);
    if (length == 0) {
      throw InputError({fmt::format("{}:{}:{}", name, line, i - line_begin + 1),
                        fmt::format("byte 0x{:02x}", static_cast<unsigned char>(text[i])),
                        "UTF-8 text", ""});
    }
    if (text[i] == '\n') {
      ++line;
      line_begin = i + 1;
    }
    i += length;
  }
}

std::string KeyPath(const Node& map, const std::string& key) {
  std::string path = map.path.empty() ? key : map.path + "." + key;
  if (path.size() > 120) path = path.substr(0, 117) + "...";
  return path;
}

YamlViolation UnknownKey(const Node& map, const std::string& key, int line) {
  const std::string nearest = NearestName(key, map.known_keys);
  return {line, KeyPath(map, key), "an unknown key",
          map.known_keys.empty() ? "no keys"
                                 : fmt::format("one of: {}", fmt::join(map.known_keys, ", ")),
          nearest.empty() ? "" : fmt::format("did you mean '{}'?", nearest)};
}

YamlViolation RepeatedKey(const Node& map, const std::string& key, int line) {
  const auto first = std::find_if(map.entries.begin(), map.entries.end(),
                                  [&](const auto& entry) { return entry.first == key; });
  return {line, KeyPath(map, key), "the same key a second time",
          fmt::format("one value (the first is at line {})", first->second->line), ""};
}

std::string ToLine(const std::string& file, const YamlViolation& v) {
  std::string text = fmt::format("  {}:{}: ", file, v.line);
  if (!v.key.empty()) text += v.key + ": ";
  text += fmt::format("found {}; expected {}", v.found, v.expected);
  if (!v.remedy.empty()) text += "; " + v.remedy;
  return CleanUtf8(text);  // keys may hold escaped control characters, and long ones are cut
}

}  // namespace

YamlDocument::YamlDocument() : tree_(std::make_unique<yaml_internal::Tree>()) {}
YamlDocument::~YamlDocument() = default;
YamlDocument::YamlDocument(YamlDocument&&) noexcept = default;
YamlDocument& YamlDocument::operator=(YamlDocument&&) noexcept = default;

YamlDocument YamlDocument::Load(const std::string& path) {
  return Parse(ReadTextFile(path, kMaxBytes), path);
}

YamlDocument YamlDocument::Parse(const std::string& text, const std::string& name) {
  CheckEncoding(text, name);
  YamlDocument document;
  document.tree_->file = name;
  yaml_internal::ParseYaml(text, *document.tree_);
  document.tree_->root->line = std::max(1, document.tree_->root->line);  // of an empty file
  return document;
}

YamlValue YamlDocument::root() { return {tree_.get(), tree_->root, "", tree_->root->line}; }

std::vector<YamlViolation> YamlDocument::Violations() const {
  std::vector<YamlViolation> all = tree_->violations;
  for (const Node& node : tree_->nodes) {
    for (const auto& [key, line] : node.repeated) all.push_back(RepeatedKey(node, key, line));
    if (!node.visited_as_map) continue;
    for (const auto& [key, value] : node.entries) {
      const auto& known = node.known_keys;
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        all.push_back(UnknownKey(node, key, value->line));
      }
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const YamlViolation& a, const YamlViolation& b) { return a.line < b.line; });
  return all;
}

void YamlDocument::ThrowIfInvalid() const {
  constexpr std::size_t kMaxListed = 200;
  const std::vector<YamlViolation> all = Violations();
  if (all.empty()) return;
  std::string list = all.size() == 1 ? "1 mistake" : fmt::format("{} mistakes", all.size());
  for (std::size_t i = 0; i < std::min(all.size(), kMaxListed); ++i) {
    list.append("\n").append(ToLine(tree_->file, all[i]));
  }
  if (all.size() > kMaxListed) list += fmt::format("\n  and {} more", all.size() - kMaxListed);
  throw InputError({tree_->file, list, "", ""});
}

}  // namespace backsight
