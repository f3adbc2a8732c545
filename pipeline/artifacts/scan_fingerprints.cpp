#include "pipeline/artifacts/scan_fingerprints.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include "core/fingerprint.h"
#include "pipeline/artifacts/artifact_keys.h"

namespace backsight {
namespace {

/// Changes whenever the file's content does.
ArtifactKey KeyOf(const std::string& path) {
  struct stat status {};
  ArtifactKey key;
  key.Add("file", path);
  if (::stat(path.c_str(), &status) != 0) return key;
  key.Add("bytes", std::to_string(status.st_size));
  key.Add("modified", fmt::format("{}.{:09}", status.st_mtim.tv_sec, status.st_mtim.tv_nsec));
  key.Add("changed", fmt::format("{}.{:09}", status.st_ctim.tv_sec, status.st_ctim.tv_nsec));
  key.Add("inode", std::to_string(status.st_ino));
  return key;
}

}  // namespace

std::string ScanFingerprints::Of(const std::string& path, const ExecutionContext& context) {
  {
    const std::scoped_lock lock(mutex_);
    const auto known = known_.find(path);
    if (known != known_.end()) return known->second;
  }
  const std::string name = FileArtifactName("scans", path);
  const ArtifactKey before = KeyOf(path);
  std::string fingerprint;
  if (!store_.Load(name, before, &fingerprint)) {
    fingerprint = FingerprintFile(path, [&] { context.CheckStop(); });
    if (KeyOf(path).text() == before.text()) store_.Store(name, before, fingerprint);
  }
  const std::scoped_lock lock(mutex_);
  known_[path] = fingerprint;
  return fingerprint;
}

}  // namespace backsight
