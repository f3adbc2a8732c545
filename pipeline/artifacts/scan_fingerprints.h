#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "core/execution.h"
#include "io/artifact_store.h"

namespace backsight {

/// What a scan file held, and how it lay there then.
struct ScanIdentity {
  std::string fingerprint;  ///< of the content
  std::string stamp;        ///< size, times and inode: as long as they stay, so does the content
};

/// Fingerprints of scan files. Reading a file for its fingerprint takes as long as reading the
/// scan, so what is found is kept with the file's stamp and believed as long as that stays, however
/// the file is spelled. Files are named as seen from the store, so that both may move together.
/// Safe to use from several threads; a file is read by one of them only.
class ScanFingerprints {
 public:
  explicit ScanFingerprints(const ArtifactStore& store) : store_(store) {}

  /// Throws InputError if the file cannot be read.
  ScanIdentity Of(const std::string& path, const ExecutionContext& context);

  /// The fingerprint, where it is known without reading the file.
  std::optional<std::string> Known(const std::string& path) const;

 private:
  struct File {
    std::mutex mutex;
    std::optional<ScanIdentity> identity;  // in this run
  };

  std::string NameOf(const std::string& path) const;
  File& FileOf(const std::string& name);
  ScanIdentity Find(const std::string& path, const std::string& name,
                    const ExecutionContext& context) const;

  const ArtifactStore& store_;
  std::mutex mutex_;
  std::map<std::string, File> files_;
};

/// Stands for the content of a file that cannot be read: another as soon as the file is changed.
std::string UnreadFingerprint(const std::string& path);

/// Throws InputError if the file no longer holds what it did. Reads it only where its stamp is
/// another.
void RequireUnchanged(const std::string& path, const ScanIdentity& before,
                      const ExecutionContext& context);

}  // namespace backsight
