#pragma once

#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "io/strict_yaml.h"

namespace backsight::yaml_internal {

/// A node of a parsed file. Children are referred to by pointers into Tree::nodes, so that the
/// depth of a document costs no stack when it is destroyed.
struct Node {
  enum class Kind { kNull, kScalar, kSequence, kMap, kRejected };
  Kind kind = Kind::kNull;
  int line = 0;
  int column = 0;
  std::string text;     ///< of a scalar
  bool quoted = false;  ///< a quoted scalar is text, never a number or flag
  std::vector<Node*> items;
  std::vector<std::pair<std::string, Node*>> entries;  ///< without duplicates, in file order
  std::vector<std::pair<std::string, int>> repeated;   ///< keys given again, with their line
  std::string path;                                    ///< key path, set when the node is visited
  bool visited_as_map = false;
  std::vector<std::string> known_keys;  ///< keys that the reader asked this map for
};

/// A parsed file and everything found wrong with it.
struct Tree {
  std::string file;
  std::deque<Node> nodes;
  Node* root = nullptr;
  std::vector<YamlViolation> violations;
};

/// Fills `tree.nodes` and `tree.root` from `text`; duplicate keys, aliases and further documents
/// become violations. Throws InputError with file:line:column for what is not YAML.
void ParseYaml(const std::string& text, Tree& tree);

}  // namespace backsight::yaml_internal
