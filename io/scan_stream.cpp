#include "io/scan_stream.h"

#include <exception>
#include <memory>
#include <vector>

namespace backsight {
namespace {

/// A block, or what went wrong with it, to be told in its turn.
struct Slot {
  std::unique_ptr<ScanBlock> block;
  std::exception_ptr fault;
};

}  // namespace

void StreamScan(ScanReader& reader, std::size_t slots, const ExecutionContext& context,
                const std::function<void(std::size_t slot, const PointChunk& points)>& work,
                const std::function<void(std::size_t slot, const PointChunk& points)>& take) {
  std::vector<Slot> places(slots);
  for (Slot& place : places) place.block = reader.NewBlock();
  bool ended = false;
  const auto fetch = [&](std::size_t slot) {
    if (ended) return false;
    places[slot].fault = nullptr;
    try {
      return reader.Fetch(*places[slot].block);
    } catch (...) {
      ended = true;
      places[slot].fault = std::current_exception();
      return true;
    }
  };
  const auto parse = [&](std::size_t slot) {
    if (places[slot].fault) return;
    try {
      reader.Parse(*places[slot].block);
      work(slot, places[slot].block->points);
    } catch (...) {
      places[slot].fault = std::current_exception();
    }
  };
  context.Stream(slots, fetch, parse, [&](std::size_t slot) {
    if (places[slot].fault) std::rethrow_exception(places[slot].fault);
    reader.Deliver(*places[slot].block);
    take(slot, places[slot].block->points);
  });
}

}  // namespace backsight
