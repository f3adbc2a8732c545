#include "io/yaml_tree.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <sstream>

#include "core/error.h"
#include "io/utf8.h"

namespace backsight::yaml_internal {
namespace {

constexpr std::size_t kMaxDepth = 64;

/// Builds the tree from the parser's events, without yaml-cpp's own node graph: every key keeps
/// its line, duplicates are seen, and aliases cannot multiply.
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(Tree& tree) : tree_(tree) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override {
    Place(Create(Node::Kind::kNull, mark));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    Node* node = Create(Node::Kind::kRejected, mark);
    tree_.violations.push_back({node->line, "", "an alias (*name)", "a value",
                                "aliases are not supported: write the value out"});
    Place(node);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                const std::string& value) override {
    Node* node = Create(Node::Kind::kScalar, mark);
    node->text = value;
    node->quoted = tag != "?" && !tag.empty();
    Place(node);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    Open(Create(Node::Kind::kSequence, mark), mark);
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    Open(Create(Node::Kind::kMap, mark), mark);
  }
  void OnMapEnd() override { open_.pop_back(); }

 private:
  struct OpenNode {
    Node* node = nullptr;
    Node* key = nullptr;  // of a map: the key whose value comes next
  };

  Node* Create(Node::Kind kind, const YAML::Mark& mark) {
    Node& node = tree_.nodes.emplace_back();
    node.kind = kind;
    node.line = mark.line + 1;
    node.column = mark.column + 1;
    return &node;
  }

  void Open(Node* node, const YAML::Mark& mark) {
    if (open_.size() >= kMaxDepth) {
      throw YAML::ParserException(mark, fmt::format("more than {} levels of nesting", kMaxDepth));
    }
    Place(node);
    open_.push_back({node, nullptr});
  }

  void Place(Node* node) {
    if (open_.empty()) {
      tree_.root = node;
    } else if (open_.back().node->kind == Node::Kind::kSequence) {
      open_.back().node->items.push_back(node);
    } else if (open_.back().key == nullptr) {
      open_.back().key = node;
    } else {
      AddEntry(*open_.back().node, *open_.back().key, node);
      open_.back().key = nullptr;
    }
  }

  void AddEntry(Node& map, const Node& key, Node* value) {
    if (key.kind == Node::Kind::kRejected) return;
    if (key.kind != Node::Kind::kScalar) {
      tree_.violations.push_back({key.line, "", "a key that is not text", "a key name", ""});
      return;
    }
    const auto same = std::find_if(map.entries.begin(), map.entries.end(),
                                   [&](const auto& entry) { return entry.first == key.text; });
    if (same != map.entries.end()) {
      map.repeated.emplace_back(key.text, key.line);
      return;
    }
    // A value may start lines below its key (block maps); what is wrong is found at the key.
    if (value->kind != Node::Kind::kScalar) value->line = key.line;
    map.entries.emplace_back(key.text, value);
  }

  Tree& tree_;
  std::vector<OpenNode> open_;
};

}  // namespace

void ParseYaml(const std::string& text, Tree& tree) {
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    TreeBuilder builder(tree);
    if (!parser.HandleNextDocument(builder)) tree.root = &tree.nodes.emplace_back();
    Tree rest;
    TreeBuilder rest_builder(rest);
    if (parser.HandleNextDocument(rest_builder)) {
      tree.violations.push_back(
          {rest.root == nullptr ? 0 : rest.root->line, "", "a second document (---)", "one", ""});
    }
  } catch (const YAML::Exception& e) {
    throw InputError({fmt::format("{}:{}:{}", tree.file, e.mark.line + 1, e.mark.column + 1),
                      "not valid YAML: " + CleanUtf8(e.msg), "", ""});
  }
  if (tree.root == nullptr) tree.root = &tree.nodes.emplace_back();
}

}  // namespace backsight::yaml_internal
