#include "storage/sqlite/state.h"
#include "storage/sqlite/stores.h"

namespace freelsd {

void SqliteImageStore::Write(const std::string& sha256, std::string_view bytes) {
  state_.images.Write(sha256, bytes);
}

std::optional<std::string> SqliteImageStore::Read(const std::string& sha256) const {
  return state_.images.Read(sha256);
}

void SqliteImageStore::RemoveUnused(const std::string& sha256) {
  const auto lock = state_.LockForWriting();
  if (!state_.IsImageNeeded(sha256)) state_.images.Remove(sha256);
}

uint64_t SqliteImageStore::NumBytes() const { return state_.images.NumBytes(); }

}  // namespace freelsd
