#include "io/strict_yaml.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <optional>

#include "io/environment_path.h"
#include "io/nearest_name.h"
#include "io/yaml_tree.h"

namespace backsight {
namespace {

using yaml_internal::Node;

std::string Printable(const std::string& text) {
  constexpr std::size_t kMaxShown = 60;
  std::string shown;
  for (const char c : text.substr(0, kMaxShown)) {
    shown += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  }
  // Never cut a UTF-8 character in two.
  if (text.size() > kMaxShown) {
    while (!shown.empty() && (static_cast<unsigned char>(shown.back()) & 0xC0U) == 0x80U) {
      shown.pop_back();
    }
    if (!shown.empty() && static_cast<unsigned char>(shown.back()) >= 0xC0U) shown.pop_back();
    shown += "...";
  }
  return "'" + shown + "'";
}

std::string Describe(const Node& node) {
  switch (node.kind) {
    case Node::Kind::kNull:
      return "nothing";
    case Node::Kind::kScalar:
      return Printable(node.text);
    case Node::Kind::kSequence:
      return fmt::format("a list of {}", node.items.size());
    case Node::Kind::kMap:
      return "a map";
    case Node::Kind::kRejected:
      break;
  }
  return "an alias";
}

std::optional<double> ParseReal(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  // from_chars also knows "inf", "nan" and a second sign, which are no decimal numbers.
  if (text.empty() || text.find_first_not_of("0123456789+-.eE") != std::string_view::npos) {
    return std::nullopt;
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string NumberRemedy(const std::string& text) {
  if (text.find(',') != std::string::npos && text.find('.') == std::string::npos) {
    return "write a decimal point, not a comma";
  }
  if (text.find_first_of(" \t") != std::string::npos) return "write the number without its unit";
  return {};
}

std::string Limits(const std::string& kind, double min, double max, std::string_view unit) {
  constexpr double kOpen = std::numeric_limits<double>::max();
  std::string text = kind;
  if (min > -kOpen && max < kOpen) {
    text += fmt::format(" from {} to {}", min, max);
  } else if (min > -kOpen) {
    text += fmt::format(" of at least {}", min);
  } else if (max < kOpen) {
    text += fmt::format(" of at most {}", max);
  }
  if (unit != "1" && !unit.empty()) text.append(" ").append(unit);
  return text;
}

}  // namespace

YamlValue::YamlValue(yaml_internal::Tree* tree, Node* node, std::string key, int line)
    : tree_(tree), node_(node), key_(std::move(key)), line_(line) {}

bool YamlValue::IsNull() const { return node_ != nullptr && node_->kind == Node::Kind::kNull; }
bool YamlValue::IsScalar() const { return node_ != nullptr && node_->kind == Node::Kind::kScalar; }
bool YamlValue::IsMap() const { return node_ != nullptr && node_->kind == Node::Kind::kMap; }
bool YamlValue::IsSequence() const {
  return node_ != nullptr && node_->kind == Node::Kind::kSequence;
}

std::string YamlValue::Where() const { return fmt::format("{}:{}", tree_->file, line_); }

void YamlValue::Reject(const std::string& expected, const std::string& remedy,
                       const std::string& found) const {
  if (node_ != nullptr && node_->kind == Node::Kind::kRejected) return;
  const std::string what = !found.empty() ? found : node_ == nullptr ? "nothing" : Describe(*node_);
  tree_->violations.push_back({line_, key_, what, expected, remedy});
}

bool YamlValue::OpenMap() const {
  if (node_ == nullptr || node_->kind == Node::Kind::kRejected) return false;
  if (node_->kind != Node::Kind::kMap) {
    Reject("a map (key: value)");
    node_->kind = Node::Kind::kRejected;  // reported once, whatever else is asked of it
    return false;
  }
  node_->visited_as_map = true;
  node_->path = key_;
  return true;
}

bool YamlValue::Has(const std::string& key) const {
  return IsMap() && std::any_of(node_->entries.begin(), node_->entries.end(),
                                [&](const auto& entry) { return entry.first == key; });
}

YamlValue YamlValue::Child(const std::string& key) const {
  const std::string path = key_.empty() ? key : key_ + "." + key;
  if (!OpenMap()) return {tree_, nullptr, path, line_};
  auto& known = node_->known_keys;
  if (std::find(known.begin(), known.end(), key) == known.end()) known.push_back(key);
  for (const auto& [name, value] : node_->entries) {
    if (name == key) return {tree_, value, path, value->line};
  }
  return {tree_, nullptr, path, line_};
}

YamlValue YamlValue::Optional(const std::string& key) const { return Child(key); }

YamlValue YamlValue::Required(const std::string& key) const {
  YamlValue child = Child(key);
  if (!child.present() && IsMap()) child.Reject("a value for the required key '" + key + "'");
  return child;
}

std::vector<YamlValue> YamlValue::Items(std::size_t min_count, std::size_t max_count) const {
  std::vector<YamlValue> items;
  if (node_ == nullptr || node_->kind == Node::Kind::kRejected) return items;
  if (!IsSequence()) {
    Reject("a list");
    node_->kind = Node::Kind::kRejected;
    return items;
  }
  const std::size_t count = node_->items.size();
  if (count < min_count || count > max_count) {
    Reject(min_count == max_count ? fmt::format("a list of {}", min_count)
           : count < min_count    ? fmt::format("a list of at least {}", min_count)
                                  : fmt::format("a list of at most {}", max_count));
    return items;
  }
  for (std::size_t i = 0; i < count; ++i) {
    Node* item = node_->items[i];
    items.push_back(YamlValue(tree_, item, fmt::format("{}[{}]", key_, i), item->line));
  }
  return items;
}

const std::string* YamlValue::Scalar(const std::string& expected, bool plain) const {
  if (node_ == nullptr || node_->kind == Node::Kind::kRejected) return nullptr;
  if (node_->kind != Node::Kind::kScalar) {
    Reject(expected);
    return nullptr;
  }
  if (plain && node_->quoted) {
    Reject(expected, "write it without quotes", "the text " + Printable(node_->text));
    return nullptr;
  }
  return &node_->text;
}

std::string YamlValue::Text(const std::string& fallback) const {
  const std::string* text = Scalar("text", false);
  if (text == nullptr) return fallback;
  if (!text->empty()) return *text;
  Reject("text", "", "empty text");
  return fallback;
}

double YamlValue::Real(double fallback, const RealRange& range) const {
  const std::string expected = Limits("a number", range.min, range.max, range.unit);
  const std::string* text = Scalar(expected, true);
  if (text == nullptr) return fallback;
  const std::optional<double> value = ParseReal(*text);
  if (value && *value >= range.min && *value <= range.max) return *value;
  Reject(expected, value ? "" : NumberRemedy(*text));
  return fallback;
}

int YamlValue::Integer(int fallback, int min, int max, std::string_view unit) const {
  const std::string expected = Limits("a whole number", min, max, unit);
  const std::string* text = Scalar(expected, true);
  if (text == nullptr) return fallback;
  int value = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error == std::errc() && end == text->data() + text->size() && value >= min && value <= max) {
    return value;
  }
  Reject(expected);
  return fallback;
}

bool YamlValue::Flag(bool fallback) const {
  const std::string* text = Scalar("true or false", true);
  if (text == nullptr || *text == "true") return text == nullptr ? fallback : true;
  if (*text == "false") return false;
  std::string lower = *text;
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  constexpr std::array<std::string_view, 5> kYes = {"yes", "y", "on", "true", "1"};
  constexpr std::array<std::string_view, 5> kNo = {"no", "n", "off", "false", "0"};
  const bool yes = std::find(kYes.begin(), kYes.end(), lower) != kYes.end();
  const bool no = std::find(kNo.begin(), kNo.end(), lower) != kNo.end();
  Reject("true or false", yes ? "write true" : no ? "write false" : "");
  return fallback;
}

int YamlValue::Choice(int fallback, const std::vector<std::string>& names) const {
  std::string expected = fmt::format("one of: {}", fmt::join(names, ", "));
  const std::string* text = Scalar(expected, false);
  if (text == nullptr) return fallback;
  const auto it = std::find(names.begin(), names.end(), *text);
  if (it != names.end()) return static_cast<int>(it - names.begin());
  const std::string nearest = NearestName(*text, names);
  Reject(expected, nearest.empty() ? "" : fmt::format("did you mean '{}'?", nearest));
  return fallback;
}

std::vector<double> YamlValue::Reals(std::size_t count, const RealRange& range) const {
  std::vector<double> values;
  for (const YamlValue& item : Items(count, count)) values.push_back(item.Real(0.0, range));
  values.resize(count);
  return values;
}

std::string YamlValue::Path() const {
  const std::string text = Text();
  if (text.empty()) return {};
  const ExpandedPath expanded = ExpandEnvironment(text);
  if (!expanded.fault.empty()) {
    Reject("a path", expanded.fault);
    return {};
  }
  const std::filesystem::path folder = std::filesystem::path(tree_->file).parent_path();
  return (folder / expanded.path).lexically_normal().string();
}

}  // namespace backsight
