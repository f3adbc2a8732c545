#pragma once

#include <optional>
#include <string>

namespace backsight {

/// Who uses a folder.
struct LockHolder {
  std::string host;
  int process = 0;
  std::string since_utc;  ///< ISO 8601
};

/// Keeps a folder for one process at a time, on network file systems too: the system's lock on
/// `folder`/run.lock, which ends with the process however that ends. The file says who holds it and
/// stays when nobody does.
class FolderLock {
 public:
  /// Makes the folder where it is missing. Throws StorageFailure where it cannot be written, and
  /// InputError where its file system knows no locks.
  explicit FolderLock(const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  bool held() const { return !holder_; }
  /// Of the lock that another process holds.
  const std::optional<LockHolder>& holder() const { return holder_; }

 private:
  int file_ = -1;
  std::optional<LockHolder> holder_;
};

/// Who holds the lock of the folder now; nobody where there is none.
std::optional<LockHolder> HolderOf(const std::string& folder);

}  // namespace backsight
