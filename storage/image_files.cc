#include "storage/image_files.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <stdexcept>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "storage/storage_error.h"

namespace freelsd {
namespace {

// One shelf (folder) for each first byte of the digest.
constexpr int kNumShelves = 256;
constexpr char kUnfinishedSuffix[] = "-part";

[[noreturn]] void Fail(const std::string& step) {
  const int error = errno;
  const bool is_full = error == ENOSPC || error == EDQUOT || error == EFBIG;
  throw StorageError(
      step, std::strerror(error), is_full ? StorageFault::kFull : StorageFault::kOther);
}

class File {
 public:
  File(const std::filesystem::path& path, int flags)
      : descriptor_(::open(path.c_str(), flags, 0640)) {
    if (descriptor_ < 0) Fail(std::string("open ").append(path.filename().string()));
  }
  ~File() { ::close(descriptor_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void Write(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t num_written = ::write(descriptor_, bytes.data(), bytes.size());
      if (num_written < 0 && errno == EINTR) continue;
      if (num_written < 0) Fail("write image");
      bytes.remove_prefix(static_cast<size_t>(num_written));
    }
  }
  void Sync() const {
    if (::fsync(descriptor_) != 0) Fail("fsync");
  }

 private:
  int descriptor_;
};

// Images leave this much of the disk to the database, or 1/16 of a small disk: deleting a flight to
// free space needs some space itself.
constexpr uintmax_t kReservedBytes = 16 << 20;
constexpr uintmax_t kReservedShare = 16;

void CheckRoom(const std::filesystem::path& folder, size_t num_bytes) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error) throw StorageError("write image", error.message());
  const uintmax_t reserved = std::min(kReservedBytes, space.capacity / kReservedShare);
  if (space.available < reserved + num_bytes) {
    throw StorageError("write image",
                       "the disk is full (a part of it is reserved for the database)",
                       StorageFault::kFull);
  }
}

// Two writers of the same image need two temporary names, also in two processes or on two machines.
std::string UniqueSuffix() {
  static const uint64_t kProcess = uint64_t{std::random_device()()} << 32U | std::random_device()();
  static std::atomic<uint64_t> next{0};
  return std::to_string(kProcess) + '.' + std::to_string(next++) + kUnfinishedSuffix;
}

}  // namespace

void SyncFolder(const std::filesystem::path& folder) {
  File(folder, O_RDONLY | O_DIRECTORY).Sync();
}

ImageFiles::ImageFiles(const std::filesystem::path& folder) : folder_(folder) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) throw StorageError("create images folder", error.message());
  // All shelves are made at start, so that writing an image never has to sync a new folder's name.
  for (const std::string& name : Shelves()) {
    if (::mkdir((folder_ / name).c_str(), 0750) != 0 && errno != EEXIST) {
      Fail("create images folder");
    }
  }
  SyncFolder(folder_);
  SyncFolder(folder_.parent_path());
}

std::vector<std::string> ImageFiles::Shelves() {
  std::vector<std::string> shelves;
  for (int shelf = 0; shelf < kNumShelves; ++shelf) {
    char name[3];
    std::snprintf(name, sizeof(name), "%02x", shelf);
    shelves.emplace_back(name);
  }
  return shelves;
}

bool ImageFiles::IsUnfinished(const std::string& name) { return name.ends_with(kUnfinishedSuffix); }

std::vector<std::string> ImageFiles::Old(const std::string& shelf, double age_s) const {
  const auto limit = std::filesystem::file_time_type::clock::now();
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& file : std::filesystem::directory_iterator(folder_ / shelf, error)) {
    const auto written = file.last_write_time(error);
    if (error || std::chrono::duration<double>(limit - written).count() < age_s) continue;
    names.push_back(file.path().filename().string());
  }
  return names;
}

std::filesystem::path ImageFiles::PathOf(const std::string& sha256) const {
  return folder_ / sha256.substr(0, 2) / sha256;
}

void ImageFiles::Write(const std::string& sha256, std::string_view bytes) const {
  const std::filesystem::path path = PathOf(sha256);
  if (!Has(sha256)) {
    CheckRoom(folder_, bytes.size());
    const std::filesystem::path unfinished = path.string() + '.' + UniqueSuffix();
    try {
      const File file(unfinished, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC);
      file.Write(bytes);
      file.Sync();
      if (::rename(unfinished.c_str(), path.c_str()) != 0) Fail("rename image");
    } catch (...) {
      ::unlink(unfinished.c_str());
      throw;
    }
  }
  // Needed also for an existing file: another thread may have renamed it and not yet synced.
  SyncFolder(path.parent_path());
}

std::optional<std::string> ImageFiles::Read(const std::string& sha256) const {
  const std::filesystem::path path = PathOf(sha256);
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file && errno == ENOENT) return std::nullopt;
  if (!file) Fail("open image");
  std::string bytes(static_cast<size_t>(file.tellg()), '\0');
  file.seekg(0).read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  // Of this image alone: nothing else has to wait for it.
  if (!file) throw std::runtime_error("the bytes of image " + sha256 + " cannot be read");
  return bytes;
}

bool ImageFiles::Has(const std::string& sha256) const {
  std::error_code error;
  return std::filesystem::exists(PathOf(sha256), error);
}

void ImageFiles::Remove(const std::string& sha256) const { ::unlink(PathOf(sha256).c_str()); }

uint64_t ImageFiles::NumBytes() const {
  uint64_t num_bytes = 0;
  std::error_code error;
  for (const auto& shelf : std::filesystem::directory_iterator(folder_, error)) {
    for (const auto& file : std::filesystem::directory_iterator(shelf.path(), error)) {
      const uintmax_t size = file.file_size(error);
      if (!error) num_bytes += size;
    }
  }
  return num_bytes;
}

void ImageFiles::RemoveUnless(const std::function<bool(const std::string&)>& is_needed) const {
  std::error_code error;
  for (const auto& shelf : std::filesystem::directory_iterator(folder_, error)) {
    for (const auto& file : std::filesystem::directory_iterator(shelf.path(), error)) {
      if (!is_needed(file.path().filename().string())) ::unlink(file.path().c_str());
    }
  }
}

}  // namespace freelsd
