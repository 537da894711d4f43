// Images, stored once per SHA-256 (lower-case hex).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace freelsd {

// Invariants: a stored image is complete, and it stays while a frame or a photo tile refers to it,
// unless FlightStore::RetireImages removes it. A name with its file is given up in one step, also
// if several processes share the folder.
class ImageStore {
 public:
  virtual ~ImageStore() = default;
  ImageStore(const ImageStore&) = delete;
  ImageStore& operator=(const ImageStore&) = delete;

  // Call it before inserting frames that refer to the image. Does nothing if the image is already
  // stored.
  virtual void Write(const std::string& sha256, std::string_view bytes) = 0;
  virtual std::optional<std::string> Read(const std::string& sha256) const = 0;
  // Removes the image unless a frame or a photo tile refers to it.
  virtual void RemoveUnused(const std::string& sha256) = 0;
  // Total size of all images.
  virtual uint64_t NumBytes() const = 0;

 protected:
  ImageStore() = default;
};

}  // namespace freelsd
