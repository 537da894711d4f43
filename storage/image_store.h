// Images, stored once per SHA-256 (lower-case hex).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace freelsd {

struct StorageState;

// Invariants: a stored image is complete, and it stays while a frame or a photo tile refers to it,
// unless FlightStore::RetireImages removes it.
class ImageStore {
 public:
  explicit ImageStore(StorageState& state) : state_(state) {}
  ImageStore(const ImageStore&) = delete;
  ImageStore& operator=(const ImageStore&) = delete;

  // Call it before inserting frames that refer to the image. Does nothing if the image is already
  // stored.
  void Write(const std::string& sha256, std::string_view bytes);
  std::optional<std::string> Read(const std::string& sha256) const;
  // Removes the image unless a frame or a photo tile refers to it.
  void RemoveUnused(const std::string& sha256);
  // Total size of all images.
  uint64_t NumBytes() const;

 private:
  StorageState& state_;
};

}  // namespace freelsd
