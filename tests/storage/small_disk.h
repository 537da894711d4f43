// A file system of its own size, to be filled.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <doctest/doctest.h>
#include <sys/mount.h>

namespace freelsd {

class SmallDisk {
 public:
  SmallDisk(const std::filesystem::path& folder, const std::string& size) : folder_(folder) {
    std::filesystem::create_directories(folder_);
    is_mounted_ = ::mount("tmpfs", folder_.c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
  }
  ~SmallDisk() {
    if (is_mounted_) ::umount2(folder_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  // False where this process may not mount.
  bool is_mounted() const { return is_mounted_; }
  bool Resize(const std::string& size) const {
    return ::mount("tmpfs", folder_.c_str(), "tmpfs", MS_REMOUNT, ("size=" + size).c_str()) == 0;
  }
  // Takes all room but that many bytes.
  void Fill(uint64_t num_left) const {
    MakeRoom();
    const uint64_t num_free = std::filesystem::space(folder_).available;
    if (num_free <= num_left) return;
    std::ofstream(folder_ / "filler") << std::string(num_free - num_left, 'x');
  }
  void MakeRoom() const { std::filesystem::remove(folder_ / "filler"); }

 private:
  std::filesystem::path folder_;
  bool is_mounted_ = false;
};

// False where this process may not mount; the test then says that it is skipped.
inline bool IsMounted(const SmallDisk& disk) {
  if (!disk.is_mounted()) MESSAGE("skipped: this process may not mount a small file system");
  return disk.is_mounted();
}

}  // namespace freelsd
