#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "io/scan_reader.h"

namespace backsight {

/// What a fuzz target says of its reader; each <reader>_fuzz.cpp defines one.
struct FuzzTarget {
  /// Reads the file to its end and checks what the reader promises.
  void (*read)(const std::string& path);
  /// Well-formed inputs to begin with.
  std::vector<std::string> (*seeds)();
  /// The file for an input. Makes good again what nearly every mutation breaks and would hide the
  /// layers behind it, such as checksums.
  std::string (*file_of)(std::string_view input);
};

FuzzTarget TargetUnderTest();

/// The file for inputs that need no repair.
inline std::string AsItIs(std::string_view input) { return std::string(input); }

using OpenFunction = std::unique_ptr<ScanReader> (*)(const std::string& path, int scan_index);

/// Reads every scan of the file, three at most. Throws InternalError where the reader breaks a
/// promise: chunks of uneven columns, coordinates that are not finite, records that were not
/// counted, a pose that is no rigid motion, a reference system that is not UTF-8.
void ReadScans(const std::string& path, OpenFunction open);

/// The same for formats of one scan per file.
template <std::unique_ptr<ScanReader> (*open)(const std::string& path)>
void ReadSingle(const std::string& path) {
  ReadScans(path, [](const std::string& file, int) { return open(file); });
}

/// Reads the file for `input`; true if that ends well, false for an InputError. Throws
/// InternalError where the reader breaks a promise, or its error does not name the file or is not
/// UTF-8.
bool ReadFuzzed(const FuzzTarget& target, std::string_view input);

}  // namespace backsight
