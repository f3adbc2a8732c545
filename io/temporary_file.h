#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/error.h"

namespace backsight {

/// A file that did not exist before, open for reading and writing. Whoever asked for it closes and
/// removes it.
struct TemporaryFile {
  int descriptor = -1;
  std::string path;
};

/// Makes an empty file in the folder of `path`, named after it. Unique within the process by a
/// counter, between processes by the process id, and between machines on a shared disk because the
/// file must not exist yet. Throws StorageFailure that names `path`.
TemporaryFile CreateTemporaryFile(const std::string& path);

/// The name that a file of CreateTemporaryFile, which a killed process left, was made for; empty
/// for other files.
std::string TargetOfTemporary(std::string_view file_name);

/// Writes all of `bytes` at `offset`. Throws StorageFailure that names `path`, e.g. for a full
/// disk.
void WriteAt(int descriptor, std::uint64_t offset, std::string_view bytes, const std::string& path);

/// A failure that may be over when the same is tried again: the disk, its server or the way there.
class TemporaryFailure : public StorageFailure {
 public:
  using StorageFailure::StorageFailure;
};

/// Throws StorageFailure of `path`, TemporaryFailure where it is one: what failed, the system's
/// reason (errno) and a remedy.
[[noreturn]] void ThrowFileError(const std::string& path, std::string_view action);

}  // namespace backsight
