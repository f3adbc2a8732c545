#pragma once

#include <map>
#include <mutex>
#include <string>

#include "core/execution.h"
#include "io/artifact_store.h"

namespace backsight {

/// Fingerprints of scan files. Reading a file for its fingerprint takes as long as reading the
/// scan, so what is found is kept with the file's size, times and inode, and believed as long as
/// these stay. Safe to use from several threads.
class ScanFingerprints {
 public:
  explicit ScanFingerprints(const ArtifactStore& store) : store_(store) {}

  /// Throws InputError if the file cannot be read.
  std::string Of(const std::string& path, const ExecutionContext& context);

 private:
  const ArtifactStore& store_;
  std::mutex mutex_;
  std::map<std::string, std::string> known_;  // in this run
};

}  // namespace backsight
