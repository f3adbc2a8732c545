#include "io/octomap_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/endian_bytes.h"

namespace backsight {
namespace {

constexpr int kLevels = 16;      // from the root to the voxels
constexpr int kBlockLevels = 3;  // from a block to its voxels

/// Writes nodes in the file's order, from the root down and child by child.
class NodeWriter {
 public:
  NodeWriter(std::span<const std::uint64_t> keys,
             const std::function<void(std::size_t i, OctomapBlock& values)>& fill)
      : keys_(keys), fill_(fill) {}

  void Run() {
    if (!keys_.empty()) WriteBlocks(kLevels, 0, keys_.size());
  }
  const std::string& bytes() const { return bytes_; }
  std::size_t nodes() const { return bytes_.size() / kNodeBytes; }

 private:
  static constexpr std::size_t kNodeBytes = sizeof(float) + 1;

  struct Node {
    float value = 0.0F;
    bool is_leaf = false;
  };

  /// The node `level` levels above the voxels that holds the blocks [begin, end).
  Node WriteBlocks(int level, std::size_t begin, std::size_t end) {
    if (level == kBlockLevels) {
      fill_(begin, values_);
      return WriteVoxels(level, 0);
    }
    const int shift = 3 * (level - 1 - kBlockLevels);
    return WriteInner([&](std::size_t child, Node* node) {
      const auto first = begin;
      while (begin < end && (keys_[begin] >> shift & 7U) == child) ++begin;
      if (begin > first) *node = WriteBlocks(level - 1, first, begin);
      return begin > first;
    });
  }

  /// The node of 8^level voxels of values_ from `begin` on, of which one at least is known.
  Node WriteVoxels(int level, std::size_t begin) {
    if (level == 0) {
      AppendNode(values_[begin], 0);
      return {values_[begin], true};
    }
    const std::size_t size = std::size_t{1} << (3 * (level - 1));
    return WriteInner([&](std::size_t child, Node* node) {
      const auto first = values_.begin() + static_cast<std::ptrdiff_t>(begin + child * size);
      const bool known = std::any_of(first, first + static_cast<std::ptrdiff_t>(size),
                                     [](float value) { return !std::isnan(value); });
      if (known) *node = WriteVoxels(level - 1, begin + child * size);
      return known;
    });
  }

  /// A node and what `write_child(child, &node)` writes below it; that returns false where there is
  /// no such child.
  template <class WriteChild>
  Node WriteInner(WriteChild write_child) {
    const std::size_t at = bytes_.size();
    AppendNode(0.0F, 0);
    Node all{-HUGE_VALF, false};
    Node child;
    unsigned children = 0;
    bool alike = true;
    float first = 0.0F;
    for (unsigned c = 0; c < 8; ++c) {
      if (!write_child(c, &child)) continue;
      if (children == 0) first = child.value;
      children |= 1U << c;
      alike = alike && child.is_leaf && child.value == first;
      all.value = std::max(all.value, child.value);
    }
    if (alike && children == 0xFFU) {
      bytes_.resize(at + kNodeBytes);
      children = 0;
      all.is_leaf = true;
    }
    SetNode(at, all.value, children);
    return all;
  }

  void AppendNode(float value, unsigned children) {
    bytes_.resize(bytes_.size() + kNodeBytes);
    SetNode(bytes_.size() - kNodeBytes, value, children);
  }
  void SetNode(std::size_t at, float value, unsigned children) {
    StoreBytes(&bytes_[at], value);
    bytes_[at + sizeof value] = static_cast<char>(children);
  }

  std::span<const std::uint64_t> keys_;
  const std::function<void(std::size_t i, OctomapBlock& values)>& fill_;
  OctomapBlock values_{};
  std::string bytes_;
};

}  // namespace

std::string OctomapBytes(double resolution_m, std::span<const std::uint64_t> keys,
                         const std::function<void(std::size_t i, OctomapBlock& values)>& fill) {
  NodeWriter writer(keys, fill);
  writer.Run();
  const std::string head = fmt::format(
      "# Octomap OcTree file\n"
      "# (feel free to add / change comments, but leave the first line as it is!)\n"
      "#\n"
      "id OcTree\nsize {}\nres {:g}\ndata\n",
      writer.nodes(), resolution_m);
  return head + writer.bytes();
}

}  // namespace backsight
