#pragma once

#include <optional>
#include <stdexcept>
#include <string>

namespace backsight {

/// Who uses a folder.
struct LockHolder {
  std::string host;
  int process = 0;
  std::string since_utc;  ///< ISO 8601
};

/// The folder is in use by another process. The message says which.
class FolderInUse : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Keeps a folder for one process at a time, on network file systems too: the system's lock on
/// `folder`/run.lock, which ends with the process however that ends. The file says who holds it and
/// stays when nobody does.
class FolderLock {
 public:
  /// Makes the folder where it is missing. Throws FolderInUse where another process holds the
  /// lock, StorageFailure where the folder cannot be written, InputError where its file system
  /// knows no locks, and TemporaryFailure where that may be over soon.
  explicit FolderLock(const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  void Lock(const std::string& path);

  int file_ = -1;
};

/// This machine's, as lock holders are told.
std::string HostName();

/// Who holds the lock of the folder now; nobody where there is none.
std::optional<LockHolder> HolderOf(const std::string& folder);

}  // namespace backsight
