#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace backsight {

/// Everything a stored result depends on: a line "name: value" each, in a fixed order. Two results
/// with equal keys are equal.
class ArtifactKey {
 public:
  void Add(std::string_view name, std::string_view value);
  /// Exact, in hexadecimal.
  void Add(std::string_view name, double value);
  /// Lines "name=value", as CanonicalText gives them.
  void AddLines(std::string_view lines);

  /// The key that has this text().
  static ArtifactKey OfText(std::string text);

  const std::string& text() const { return text_; }
  /// 32 hexadecimal digits that stand for the text, as another key's value.
  std::string Digest() const;

 private:
  std::string text_;
};

/// What is stored under a name, against the key that is wanted.
struct ArtifactState {
  enum class Kind { kUpToDate, kMissing, kOutdated, kDamaged };
  Kind kind = Kind::kMissing;
  /// Outdated: the names of the key's lines that differ. Damaged: what is wrong with the file.
  std::vector<std::string> why;
  std::string key_text;  ///< that is stored; empty where it is missing or damaged
};

/// Bytes that need not be in memory at once.
struct ArtifactBytes {
  std::uint64_t size = 0;
  /// Calls `put` with one piece after the other, `size` bytes in all.
  std::function<void(const std::function<void(std::string_view)>& put)> write;
};

/// Results of finished work in a folder, each in a file "NAME.artifact" that holds its whole key,
/// its length and a checksum (XXH3-128). Files appear whole or not at all. Objects of several
/// processes may share the folder.
class ArtifactStore {
 public:
  /// A store that holds and keeps nothing.
  ArtifactStore() = default;
  /// `report` hears of damaged artifacts; may be empty.
  explicit ArtifactStore(std::string folder, std::function<void(const std::string&)> report = {});

  bool keeps() const { return !folder_.empty(); }
  const std::string& folder() const { return folder_; }

  /// The bytes stored under `name`, if they belong to `key` and are whole. False otherwise; what is
  /// damaged is reported, whatever key it seems to have.
  bool Load(const std::string& name, const ArtifactKey& key, std::string* bytes) const;
  /// Throws StorageFailure where the disk does not take it; what was stored before then stays.
  void Store(const std::string& name, const ArtifactKey& key, const ArtifactBytes& bytes) const;
  void Store(const std::string& name, const ArtifactKey& key, std::string_view bytes) const;
  /// Reads the key only: damage within the bytes is not found.
  ArtifactState Look(const std::string& name, const ArtifactKey& key) const;

  /// Reports that what is stored under `name` cannot be used.
  void ReportDamaged(const std::string& name, const std::string& fault) const;

  void Remove(const std::string& name) const;
  /// The artifact's file.
  std::string PathOf(const std::string& name) const;

 private:
  std::string folder_;
  std::function<void(const std::string&)> report_;
};

/// The values of a key text's lines by their names.
std::multimap<std::string, std::string> KeyLines(std::string_view text);

/// The names of lines that two key texts do not share, in order, each once.
std::vector<std::string> DifferingLines(std::string_view a, std::string_view b);

}  // namespace backsight
