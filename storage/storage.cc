#include "storage/storage.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "storage/state.h"

namespace freelsd {
namespace {

// Below this free space the service says that it is not ready: results must still fit.
constexpr uint64_t kMinFreeBytes = uint64_t{256} << 20;

std::filesystem::path MadeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw StorageError("create folder " + folder.string(), error.message());
  return folder;
}

}  // namespace

StorageError::StorageError(const std::string& step, const std::string& reason, StorageFault kind)
    : std::runtime_error(step + ": " + reason), fault(kind) {}

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(::open((folder / "freelsd.lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0640)) {
  if (descriptor_ < 0) throw StorageError("open the lock file", std::strerror(errno));
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    ::close(descriptor_);
    throw StorageError("lock " + folder.string(), "another freelsd-server uses this folder");
  }
}

FolderLock::~FolderLock() { ::close(descriptor_); }

std::unique_ptr<Connection> ReaderPool::Take() {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      std::unique_ptr<Connection> connection = std::move(idle_.back());
      idle_.pop_back();
      return connection;
    }
  }
  return std::make_unique<Connection>(file_, Access::kRead);
}

void ReaderPool::GiveBack(std::unique_ptr<Connection> connection) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(connection));
}

Storage::Storage(const std::filesystem::path& folder) : state_(Opened(folder)) {
  std::error_code error;
  std::filesystem::remove_all(SpoolFolder(), error);
  MadeFolder(SpoolFolder());
}

Storage::~Storage() = default;

std::filesystem::path Storage::SpoolFolder() const { return state_->folder / "spool"; }

void Storage::WriteImage(const std::string& sha256, std::string_view bytes) {
  state_->images.Write(sha256, bytes);
}

std::optional<std::string> Storage::ReadImage(const std::string& sha256) const {
  return state_->images.Read(sha256);
}

void Storage::RemoveUnusedImage(const std::string& sha256) {
  const auto lock = state_->LockForWriting();
  Statement statement = state_->writer.Prepare("SELECT 1 FROM frames WHERE sha256 = ?1 LIMIT 1");
  if (!statement.Bind(sha256).Step()) state_->images.Remove(sha256);
}

void Storage::MarkDamaged(const std::string& why) const { state_->MarkDamaged(why); }

std::vector<std::string> Storage::Notices() const {
  const std::lock_guard lock(state_->notices_mutex);
  return state_->notices;
}

std::optional<std::string> Storage::WhyNotWritable() const {
  if (state_->is_damaged) return "the database is damaged";
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(state_->folder, error);
  if (error) return error.message();
  if (space.available < kMinFreeBytes) return "less than 256 MiB are free on the disk";
  try {
    const auto lock = state_->LockForWriting();
    const Transaction transaction(state_->writer);
  } catch (const StorageError& failure) {
    return failure.what();
  }
  return std::nullopt;
}

}  // namespace freelsd
