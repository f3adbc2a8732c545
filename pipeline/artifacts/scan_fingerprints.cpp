#include "pipeline/artifacts/scan_fingerprints.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <filesystem>

#include "core/error.h"
#include "core/fingerprint.h"
#include "io/output_names.h"
#include "pipeline/artifacts/artifact_keys.h"

namespace backsight {
namespace {

/// Changes whenever the file's content does.
ArtifactKey StampOf(const std::string& path) {
  struct stat status {};
  ArtifactKey key;
  if (::stat(path.c_str(), &status) != 0) return key;
  key.Add("bytes", std::to_string(status.st_size));
  key.Add("modified", fmt::format("{}.{:09}", status.st_mtim.tv_sec, status.st_mtim.tv_nsec));
  key.Add("changed", fmt::format("{}.{:09}", status.st_ctim.tv_sec, status.st_ctim.tv_nsec));
  key.Add("inode", std::to_string(status.st_ino));
  return key;
}

ArtifactKey KeyOf(const std::string& name, ArtifactKey stamp) {
  stamp.Add("file", name);
  return stamp;
}

}  // namespace

std::string ScanFingerprints::NameOf(const std::string& path) const {
  const std::filesystem::path file = FileKey(path);
  return store_.keeps() ? file.lexically_proximate(FileKey(store_.folder())).string()
                        : file.string();
}

ScanFingerprints::File& ScanFingerprints::FileOf(const std::string& name) {
  const std::scoped_lock lock(mutex_);
  return files_[name];
}

ScanIdentity ScanFingerprints::Of(const std::string& path, const ExecutionContext& context) {
  const std::string name = NameOf(path);
  File& file = FileOf(name);
  const std::scoped_lock lock(file.mutex);
  if (!file.identity) file.identity = Find(path, name, context);
  return *file.identity;
}

ScanIdentity ScanFingerprints::Find(const std::string& path, const std::string& name,
                                    const ExecutionContext& context) const {
  const ArtifactKey stamp = StampOf(path);
  const ArtifactKey key = KeyOf(name, stamp);
  const std::string artifact = FileArtifactName("scans", name);
  ScanIdentity identity{"", stamp.text()};
  if (store_.Load(artifact, key, &identity.fingerprint)) return identity;
  identity.fingerprint = FingerprintFile(path, [&] { context.CheckStop(); });
  if (StampOf(path).text() == identity.stamp) store_.Store(artifact, key, identity.fingerprint);
  return identity;
}

std::optional<std::string> ScanFingerprints::Known(const std::string& path) const {
  const std::string name = NameOf(path);
  std::string fingerprint;
  const ArtifactKey key = KeyOf(name, StampOf(path));
  if (!store_.Load(FileArtifactName("scans", name), key, &fingerprint)) return std::nullopt;
  return fingerprint;
}

std::string UnreadFingerprint(const std::string& path) {
  return "unread " + StampOf(path).Digest();
}

void RequireUnchanged(const std::string& path, const ScanIdentity& before,
                      const ExecutionContext& context) {
  if (StampOf(path).text() == before.stamp) return;
  if (FingerprintFile(path, [&] { context.CheckStop(); }) == before.fingerprint) return;
  throw InputError({path, "it changed during the run", "the scan that its station was made from",
                    "run again when nothing writes the scan"});
}

}  // namespace backsight
