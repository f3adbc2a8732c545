#pragma once

#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace backsight {

namespace yaml_internal {
struct Node;
struct Tree;
}  // namespace yaml_internal

/// One thing wrong with a YAML file.
struct YamlViolation {
  int line = 0;          ///< from 1
  std::string key;       ///< path of the key: "stations[2].scan"; empty: the document
  std::string found;     ///< the value found, or what it is
  std::string expected;  ///< what is allowed
  std::string remedy;    ///< may be empty
};

/// Inclusive bounds of a number and its unit ("m", "deg", "1" for a ratio or count).
struct RealRange {
  double min = -std::numeric_limits<double>::max();
  double max = std::numeric_limits<double>::max();
  std::string_view unit = "1";
};

/// A place in a YAML document that may hold a value; cheap to copy, valid as long as its
/// YamlDocument. No function throws for what the file holds: whatever is wrong joins the
/// document's list of violations (once), and the fallback is returned. An absent value (optional
/// key, or a key whose absence is reported already) silently gives the fallback.
class YamlValue {
 public:
  bool present() const { return node_ != nullptr; }
  /// Present with nothing written behind the key.
  bool IsNull() const;
  bool IsScalar() const;
  bool IsSequence() const;
  bool IsMap() const;
  /// Line of the key, from 1; of the parent where absent.
  int line() const { return line_; }
  const std::string& key() const { return key_; }
  /// "survey.yaml:12"
  std::string Where() const;

  /// The value of a key of this map; every key asked for counts as known, all others are reported
  /// by YamlDocument::ThrowIfInvalid with the nearest known key.
  YamlValue Required(const std::string& key) const;
  YamlValue Optional(const std::string& key) const;
  /// True if the key is there, without making it a known key.
  bool Has(const std::string& key) const;

  /// The elements of this sequence.
  std::vector<YamlValue> Items(std::size_t min_count = 0, std::size_t max_count = 1000000) const;

  /// Any scalar but an empty one, as written (a plain 7 is the text "7").
  std::string Text(const std::string& fallback = {}) const;
  /// A finite decimal number, integers included; quoted numbers are text.
  double Real(double fallback, const RealRange& range = {}) const;
  /// A decimal integer within [min, max].
  int Integer(int fallback, int min, int max, std::string_view unit = "1") const;
  /// true or false; "yes", "on" and the like are refused with advice.
  bool Flag(bool fallback) const;
  /// Index into `names`.
  int Choice(int fallback, const std::vector<std::string>& names) const;
  /// A sequence of exactly `count` numbers; `count` zeros where it is wrong or absent.
  std::vector<double> Reals(std::size_t count, const RealRange& range = {}) const;
  /// A path with every ${NAME} replaced by that environment variable (unset or empty: a violation),
  /// relative ones taken from the folder of the YAML file. Empty if wrong or absent.
  std::string Path() const;

  /// Adds a violation here, for rules that only the caller knows. The value found is named as
  /// written if `found` is empty.
  void Reject(const std::string& expected, const std::string& remedy = {},
              const std::string& found = {}) const;

 private:
  friend class YamlDocument;
  YamlValue(yaml_internal::Tree* tree, yaml_internal::Node* node, std::string key, int line);

  bool OpenMap() const;
  /// The scalar's text; nullptr if there is none, reported with `expected`.
  const std::string* Scalar(const std::string& expected, bool plain) const;
  YamlValue Child(const std::string& key) const;

  yaml_internal::Tree* tree_ = nullptr;
  yaml_internal::Node* node_ = nullptr;
  std::string key_;
  int line_ = 0;
};

/// A YAML file under strict reading. One document per file, UTF-8, at most 16 MB and 64 levels of
/// nesting, no aliases. Not thread-safe.
class YamlDocument {
 public:
  /// Throws InputError for a missing or unreadable file and, with file:line:column, for what is
  /// not UTF-8 or not YAML.
  static YamlDocument Load(const std::string& path);
  /// `name` stands for the file in messages; relative paths are taken from its folder.
  static YamlDocument Parse(const std::string& text, const std::string& name);

  ~YamlDocument();
  YamlDocument(YamlDocument&&) noexcept;
  YamlDocument& operator=(YamlDocument&&) noexcept;

  YamlValue root();

  /// Everything wrong so far, unknown keys of the maps visited included, sorted by line.
  std::vector<YamlViolation> Violations() const;
  /// Throws one InputError that lists all violations, if there are any. Call it once, when
  /// everything has been read.
  void ThrowIfInvalid() const;

 private:
  YamlDocument();
  std::unique_ptr<yaml_internal::Tree> tree_;
};

}  // namespace backsight
