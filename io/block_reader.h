#pragma once

#include <memory>
#include <utility>

#include "io/scan_reader.h"

namespace backsight {

/// A reader whose records are taken from the file first and understood afterwards, block by block:
/// `Block` is a ScanBlock with room for them.
template <class Block>
class BlockReader : public ScanReader {
 public:
  bool Next(PointChunk& chunk) final {
    chunk.Clear();
    if (!Take(own_)) return false;
    Decode(own_);
    Count(own_);
    std::swap(chunk, own_.points);
    return true;
  }
  std::unique_ptr<ScanBlock> NewBlock() const final { return std::make_unique<Block>(); }
  bool Fetch(ScanBlock& block) final { return Take(static_cast<Block&>(block)); }
  void Parse(ScanBlock& block) const final { Decode(static_cast<Block&>(block)); }
  void Deliver(ScanBlock& block) final { Count(static_cast<Block&>(block)); }

 private:
  /// Fetch, Parse and Deliver of ScanReader. Decode replaces the block's points.
  virtual bool Take(Block& block) = 0;
  virtual void Decode(Block& block) const = 0;
  virtual void Count(Block& block) = 0;

  Block own_;
};

}  // namespace backsight
