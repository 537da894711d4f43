#include "storage/image_store.h"

#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/state.h"

namespace freelsd {

void ImageStore::Write(const std::string& sha256, std::string_view bytes) {
  state_.images.Write(sha256, bytes);
}

std::optional<std::string> ImageStore::Read(const std::string& sha256) const {
  return state_.images.Read(sha256);
}

void ImageStore::RemoveUnused(const std::string& sha256) {
  const auto lock = state_.LockForWriting();
  if (!IsImageNeeded(state_.writer, sha256)) state_.images.Remove(sha256);
}

uint64_t ImageStore::NumBytes() const { return state_.images.NumBytes(); }

}  // namespace freelsd
