#include "storage/folder_lock.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "storage/storage_error.h"

namespace freelsd {

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(::open((folder / "freelsd.lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0640)) {
  if (descriptor_ < 0) throw StorageError("open the lock file", std::strerror(errno));
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    ::close(descriptor_);
    throw StorageError("lock " + folder.string(), "another freelsd-server uses this folder");
  }
}

FolderLock::~FolderLock() { ::close(descriptor_); }

}  // namespace freelsd
