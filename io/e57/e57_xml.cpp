#include "io/e57/e57_xml.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <pugixml.hpp>

#include "io/text_fields.h"

namespace backsight {
namespace {

constexpr std::uint64_t kMaxXmlBytes = std::uint64_t{1} << 25U;

pugi::xml_node NodeOf(void* node) {
  return pugi::xml_node(static_cast<pugi::xml_node_struct*>(node));
}

std::optional<std::int64_t> ParseInteger(std::string_view text) {
  std::int64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

std::optional<double> ParseFinite(std::string_view text) {
  const std::optional<double> value = ParseNumber(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

}  // namespace

std::string_view E57Element::name() const { return NodeOf(node_).name(); }
std::string_view E57Element::type() const { return Attribute("type"); }

E57Element E57Element::Child(std::string_view name) const {
  const pugi::xml_node child = NodeOf(node_).find_child(
      [name](const pugi::xml_node& node) { return std::string_view(node.name()) == name; });
  return {source_, child.internal_object()};
}

E57Element E57Element::Require(std::string_view name) const {
  const E57Element child = Child(name);
  if (!child.exists()) {
    throw Error(fmt::format("no element '{}'", name), "an element of that name");
  }
  return child;
}

std::vector<E57Element> E57Element::Children() const {
  std::vector<E57Element> children;
  for (const pugi::xml_node child : NodeOf(node_).children()) {
    if (child.type() == pugi::node_element) {
      children.push_back({source_, child.internal_object()});
    }
  }
  return children;
}

std::string E57Element::Text() const {
  std::string text;
  // A string that contains "]]>" is split into several CDATA sections.
  for (const pugi::xml_node child : NodeOf(node_).children()) {
    const bool is_text = child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata;
    if (is_text) text += child.value();
  }
  return text;
}

std::int64_t E57Element::Integer() const {
  const std::string text = Text();
  const std::string_view trimmed = Trim(text);
  if (trimmed.empty()) return 0;
  const std::optional<std::int64_t> value = ParseInteger(trimmed);
  if (!value) throw Error(Quoted(text), "an integer of 64 bits");
  return *value;
}

double E57Element::Real() const {
  if (type() == "ScaledInteger") {
    const double scaled = static_cast<double>(Integer()) * RealAttribute("scale").value_or(1.0) +
                          RealAttribute("offset").value_or(0.0);
    if (!std::isfinite(scaled)) throw Error(fmt::format("{}", scaled), "a finite number");
    return scaled;
  }
  const std::string text = Text();
  const std::string_view trimmed = Trim(text);
  if (trimmed.empty()) return 0.0;
  const std::optional<double> value = ParseFinite(trimmed);
  if (!value) throw Error(Quoted(text), "a finite number");
  return *value;
}

std::optional<std::int64_t> E57Element::IntegerAttribute(std::string_view name) const {
  const std::string_view text = Attribute(name);
  if (text.empty()) return std::nullopt;
  const std::optional<std::int64_t> value = ParseInteger(text);
  if (!value) throw Error(fmt::format("{} {}", name, Quoted(text)), "an integer of 64 bits");
  return value;
}

std::optional<double> E57Element::RealAttribute(std::string_view name) const {
  const std::string_view text = Attribute(name);
  if (text.empty()) return std::nullopt;
  const std::optional<double> value = ParseFinite(text);
  if (!value) throw Error(fmt::format("{} {}", name, Quoted(text)), "a finite number");
  return value;
}

std::string_view E57Element::Attribute(std::string_view name) const {
  const pugi::xml_attribute attribute = NodeOf(node_).find_attribute(
      [name](const pugi::xml_attribute& a) { return std::string_view(a.name()) == name; });
  return Trim(attribute.value());
}

std::uint64_t E57Element::offset() const {
  const std::ptrdiff_t within = NodeOf(node_).offset_debug();
  return source_->start + static_cast<std::uint64_t>(std::max<std::ptrdiff_t>(within, 0));
}

InputError E57Element::Error(std::string found, std::string expected) const {
  return source_->file.Error(offset(), fmt::format("in XML element {}: {}", Quoted(name()), found),
                             std::move(expected));
}

struct E57Xml::Parsed {
  std::string text;  // the document points into it
  pugi::xml_document document;
};

E57Xml::E57Xml(PagedFile& file) : source_{file, 0}, parsed_(std::make_unique<Parsed>()) {
  const auto& [physical_bytes, offset, bytes] = file.header();
  source_.start = file.Logical(offset, 24, "the XML section");
  if (bytes == 0 || bytes > kMaxXmlBytes || bytes > file.size() - source_.start) {
    throw file.Error(
        32, fmt::format("an XML section of {} bytes", bytes),
        fmt::format("1 to {} bytes", std::min(kMaxXmlBytes, file.size() - source_.start)));
  }
  parsed_->text.resize(static_cast<std::size_t>(bytes));
  file.Read(source_.start, parsed_->text.data(), parsed_->text.size(), "bytes of XML");
  const pugi::xml_parse_result result = parsed_->document.load_buffer_inplace(
      parsed_->text.data(), parsed_->text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!result) {
    throw file.Error(source_.start + static_cast<std::uint64_t>(result.offset),
                     fmt::format("damaged XML: {}", result.description()), "well-formed XML");
  }
  if (root().name() != "e57Root") {
    throw file.Error(source_.start, fmt::format("XML of {}", Quoted(root().name())), "'e57Root'");
  }
}

E57Xml::~E57Xml() = default;

E57Element E57Xml::root() const {
  return {&source_, parsed_->document.document_element().internal_object()};
}

}  // namespace backsight
