#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "io/scan_reader.h"

namespace backsight {

/// What a fuzz target says of its reader; each <reader>_fuzz.cpp defines one.
struct FuzzTarget {
  std::unique_ptr<ScanReader> (*open)(const std::string& path, int scan_index);
  /// Well-formed inputs to begin with.
  std::vector<std::string> (*seeds)();
  /// The file for an input. Makes good again what nearly every mutation breaks and would hide the
  /// layers behind it, such as checksums.
  std::string (*file_of)(std::string_view input);
};

FuzzTarget TargetUnderTest();

/// Reads every scan (three at most) of the file for `input`; true if all of them end well, false
/// for an InputError. Throws InternalError where the reader breaks a promise: chunks of uneven
/// columns, coordinates that are not finite, an error that does not name its file.
bool ReadFuzzed(const FuzzTarget& target, std::string_view input);

}  // namespace backsight
