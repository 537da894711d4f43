#include "storage/postgres/images.h"

#include <set>

#include "storage/postgres/state.h"

namespace freelsd {
namespace {

void RemoveUnused(PostgresState& state, const std::string& sha256) {
  PostgresWrite writer(state);
  // Locks the row, also where there is none yet. The next statement sees all that was committed
  // before; who then refers to the image waits and fails.
  writer->Run(
      "INSERT INTO images (sha256, num_bytes) VALUES ($1, 0) "
      "ON CONFLICT (sha256) DO UPDATE SET num_bytes = images.num_bytes",
      sha256);
  writer->Run("SELECT 1 FROM images WHERE sha256 = $1 FOR UPDATE", sha256);
  const int64_t num_removed =
      writer
          ->Run(
              "DELETE FROM images WHERE sha256 = $1 "
              "AND NOT EXISTS (SELECT 1 FROM frames WHERE stored_image = $1) "
              "AND NOT EXISTS (SELECT 1 FROM photo_tiles WHERE sha256 = $1)",
              sha256)
          .NumChanges();
  if (num_removed == 0) return;
  state.images.Remove(sha256);
  writer.Commit();
}

bool TakeSweep(PostgresState& state) {
  PostgresWrite writer(state);
  const bool is_due =
      writer
          ->Run(
              "UPDATE sweeps SET swept_at = clock_timestamp() WHERE name = 'images' "
              "AND swept_at <= clock_timestamp() - make_interval(secs => $1)",
              state.options.unused_image_age_s)
          .NumChanges() > 0;
  writer.Commit();
  return is_due;
}

std::vector<std::string> OldUnusedRows(PostgresState& state) {
  return state.Read([&](PostgresConnection& connection) {
    return connection
        .Run(
            "SELECT sha256 FROM images WHERE written_at <= now() - make_interval(secs => $1) "
            "AND NOT EXISTS (SELECT 1 FROM frames WHERE stored_image = images.sha256) "
            "AND NOT EXISTS (SELECT 1 FROM photo_tiles WHERE sha256 = images.sha256)",
            state.options.unused_image_age_s)
        .Texts();
  });
}

// 'g' follows the hexadecimal digits.
std::set<std::string> RowsOfShelf(PostgresState& state, const std::string& shelf) {
  const std::vector<std::string> rows = state.Read([&](PostgresConnection& connection) {
    return connection
        .Run("SELECT sha256 FROM images WHERE sha256 >= $1 AND sha256 < $1 || 'g'", shelf)
        .Texts();
  });
  return {rows.begin(), rows.end()};
}

}  // namespace

void RemoveUnusedImages(PostgresState& state, const std::vector<std::string>& images) {
  for (const std::string& sha256 : images) RemoveUnused(state, sha256);
}

void SweepImages(PostgresState& state) {
  if (!TakeSweep(state)) return;
  RemoveUnusedImages(state, OldUnusedRows(state));
  // Files that a process left before it stored their row.
  for (const std::string& shelf : ImageFiles::Shelves()) {
    const std::set<std::string> rows = RowsOfShelf(state, shelf);
    for (const std::string& name : state.images.Old(shelf, state.options.unused_image_age_s)) {
      if (ImageFiles::IsUnfinished(name)) {
        state.images.Remove(name);
      } else if (!rows.contains(name)) {
        RemoveUnused(state, name);
      }
    }
  }
}

}  // namespace freelsd
