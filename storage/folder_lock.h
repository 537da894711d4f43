// A lock that gives one process exclusive use of the data folder.
#pragma once

#include <filesystem>

namespace freelsd {

// Holds the lock during its lifetime. Throws StorageError if another process holds it.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace freelsd
