#include "storage/postgres/images.h"
#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {

void PostgresImageStore::Write(const std::string& sha256, std::string_view bytes) {
  PostgresWrite writer(state_);
  // The row's lock comes first: nobody removes the file until the row is committed.
  writer->Run(
      "INSERT INTO images (sha256, num_bytes) VALUES ($1, $2) "
      "ON CONFLICT (sha256) DO UPDATE SET num_bytes = $2, written_at = now()",
      sha256,
      static_cast<int64_t>(bytes.size()));
  state_.images.Write(sha256, bytes);
  writer.Commit();
}

std::optional<std::string> PostgresImageStore::Read(const std::string& sha256) const {
  return state_.images.Read(sha256);
}

void PostgresImageStore::RemoveUnused(const std::string& sha256) {
  RemoveUnusedImages(state_, {sha256});
}

uint64_t PostgresImageStore::NumBytes() const {
  return state_.Read([](PostgresConnection& connection) {
    const PostgresRows rows =
        connection.Run("SELECT coalesce(sum(num_bytes), 0)::bigint FROM images");
    return static_cast<uint64_t>(rows[0].Int(0));
  });
}

}  // namespace freelsd
