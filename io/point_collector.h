#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "core/point_chunk.h"
#include "io/scan_reader.h"

namespace backsight {

/// Records that one call of ScanReader::Next reads at most.
inline constexpr std::size_t kChunkRecords = 16384;

/// Raw intensities that become 0 and 1.
struct IntensityRange {
  double low = 0.0;
  double high = 1.0;
};

/// Raw colour value that becomes 65535: 8 bit, 16 bit, or floating point 0 to 1.
enum class ColorScale { k8Bit, k16Bit, kUnit };

/// One colour channel as 0 to 65535; 8 bit values v become v * 257. Out of range is clamped.
std::uint16_t ScaleColor(double value, ColorScale scale);

/// What all readers do with a record: drop and count what is no point, bring the rest to
/// Backsight's units.
class PointCollector {
 public:
  /// `structured`: records (0, 0, 0) are grid cells without a return.
  void Configure(bool structured, IntensityRange range) {
    structured_ = structured;
    range_ = range;
  }

  /// Counts a record and appends it if it is a point; only then (true) its attributes follow.
  bool AddPoint(double x, double y, double z, PointChunk& chunk);
  /// Counts a record that the file itself marks as no point.
  void DropInvalid() {
    ++tally_.records;
    ++tally_.no_return;
  }
  void AddIntensity(double raw, PointChunk& chunk);
  /// The grid cell of a point, from 0; one outside the grid becomes the nearest inside.
  void AddCell(double row, double column, const ScanInfo& grid, PointChunk& chunk);
  /// Counts a record that the file itself declares deleted.
  void SkipWithheld() { ++tally_.records, ++tally_.withheld; }
  void AddNote(std::string note) { tally_.notes.push_back(std::move(note)); }
  /// One for a part of the scan: of the same settings, with nothing counted.
  PointCollector ForPart() const;
  /// Adds what was counted of a part; notes are not.
  void Add(const PointCollector& part);
  /// Adds the closing notes to the tally; call it once, at the end of the scan.
  void Finish();

  const ScanTally& tally() const { return tally_; }

 private:
  bool structured_ = false;
  IntensityRange range_;
  ScanTally tally_;
  std::uint64_t clamped_ = 0;
  std::uint64_t outside_grid_ = 0;
};

}  // namespace backsight
