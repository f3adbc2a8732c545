#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/e57/paged_file.h"

namespace backsight {

/// An element of the XML section of an E57 file; valid as long as its E57Xml. All functions throw
/// InputError with file and physical byte offset where the element is not what they want.
class E57Element {
 public:
  bool exists() const { return node_ != nullptr; }
  std::string_view name() const;
  /// The attribute "type"; empty if there is none.
  std::string_view type() const;
  /// The first child element of this name; may not exist.
  E57Element Child(std::string_view name) const;
  /// The first child of this name; throws if there is none.
  E57Element Require(std::string_view name) const;
  std::vector<E57Element> Children() const;

  std::string Text() const;
  /// Content as an Integer element; nothing means 0.
  std::int64_t Integer() const;
  /// Content of an Integer, ScaledInteger or Float element; finite, nothing means 0.
  double Real() const;
  std::optional<std::int64_t> IntegerAttribute(std::string_view name) const;
  std::optional<double> RealAttribute(std::string_view name) const;  ///< finite
  std::string_view Attribute(std::string_view name) const;

  /// Logical offset of the element in the file.
  std::uint64_t offset() const;
  InputError Error(std::string found, std::string expected) const;

 private:
  friend class E57Xml;
  struct Source {
    const PagedFile& file;
    std::uint64_t start;  // logical offset of the XML section
  };
  E57Element(const Source* source, void* node) : source_(source), node_(node) {}

  const Source* source_ = nullptr;
  void* node_ = nullptr;  // pugi::xml_node_struct
};

/// The XML section of an E57 file (ASTM E2807, clause 8), parsed.
class E57Xml {
 public:
  /// Throws InputError for malformed XML, more than 32 MB of it, or a root that is no e57Root.
  explicit E57Xml(PagedFile& file);
  ~E57Xml();
  E57Xml(const E57Xml&) = delete;
  E57Xml& operator=(const E57Xml&) = delete;

  E57Element root() const;

 private:
  struct Parsed;
  E57Element::Source source_;
  std::unique_ptr<Parsed> parsed_;
};

}  // namespace backsight
