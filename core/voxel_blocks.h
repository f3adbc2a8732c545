#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/key_slot.h"

namespace backsight {

/// Blocks of 8 x 8 x 8 voxels in a hash table, made where they are first asked for. A block's key
/// is the Morton code of its voxels without the lowest nine bits.
template <class Block>
class VoxelBlocks {
 public:
  static constexpr int kVoxelBits = 9;  // of a Morton code, within a block

  VoxelBlocks() : slots_(kFewestSlots, kEmpty) {}

  /// A new block is Block{}. The reference holds until the next call.
  Block& At(std::uint64_t key) {
    std::size_t slot = KeySlot(key, slots_.size() - 1);
    for (; slots_[slot] != kEmpty; slot = Next(slot)) {
      if (keys_[slots_[slot]] == key) return blocks_[slots_[slot]];
    }
    slots_[slot] = static_cast<std::uint32_t>(keys_.size());
    keys_.push_back(key);
    blocks_.emplace_back();
    if (2 * keys_.size() > slots_.size()) Grow();
    return blocks_.back();
  }

  /// Null where it was never asked for.
  const Block* Find(std::uint64_t key) const {
    std::size_t slot = KeySlot(key, slots_.size() - 1);
    while (slots_[slot] != kEmpty && keys_[slots_[slot]] != key) slot = Next(slot);
    return slots_[slot] != kEmpty ? &blocks_[slots_[slot]] : nullptr;
  }

  std::size_t size() const { return keys_.size(); }
  /// In the order in which they were first asked for.
  const std::vector<std::uint64_t>& keys() const { return keys_; }
  const std::vector<Block>& blocks() const { return blocks_; }
  /// Memory in use.
  std::size_t Bytes() const {
    return slots_.capacity() * sizeof(std::uint32_t) + keys_.capacity() * sizeof(std::uint64_t) +
           blocks_.capacity() * sizeof(Block);
  }

 private:
  static constexpr std::uint32_t kEmpty = ~0U;
  static constexpr std::size_t kFewestSlots = 64;

  std::size_t Next(std::size_t slot) const { return (slot + 1) & (slots_.size() - 1); }

  void Grow() {
    slots_.assign(2 * slots_.size(), kEmpty);
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      std::size_t slot = KeySlot(keys_[i], slots_.size() - 1);
      while (slots_[slot] != kEmpty) slot = Next(slot);
      slots_[slot] = static_cast<std::uint32_t>(i);
    }
  }

  std::vector<std::uint32_t> slots_;  // a power of two, at most half of them taken
  std::vector<std::uint64_t> keys_;
  std::vector<Block> blocks_;
};

}  // namespace backsight
