// What follows the numbers of the feed of changes: the second copy, and servers that follow this
// one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

#include "storage/sqlite/sqlite.h"
#include "storage/storage_error.h"

namespace freelsd {

inline constexpr char kDatabaseName[] = "freelsd.db";
// The second copy of sites, maps and obstacles.
inline constexpr char kCopyName[] = "recall.db";
// Tells which file the database was at the last start.
inline constexpr char kDatabaseFileName[] = "database-file";

// Whether the database is a backup that was put back: its numbers of changes and of maps then go on
// from earlier ones, and a server that follows may know later ones that are lost here. Compares the
// database file (device and inode) with the one of the last start. If it is another one, gives the
// feed a new id: who follows begins anew. Returns the lowest number that no map had before the
// database was put back.
int64_t FirstMapNumberOf(const std::filesystem::path& folder,
                         const std::filesystem::path& database,
                         Connection& writer);

// Thrown if the second copy is damaged.
struct CopyDamaged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Runs `act` on the connection. Damage that it finds is CopyDamaged if the file is the second copy.
template <typename Act>
auto On(Connection& connection, const Act& act) {
  try {
    return act(connection);
  } catch (const StorageError& error) {
    if (error.fault != StorageFault::kDamaged || connection.FileName() != kCopyName) throw;
    throw CopyDamaged(error.what());
  }
}

// How many things a database holds.
struct NumStored {
  int64_t num_sites = 0;
  int64_t num_maps = 0;
  int64_t num_obstacles = 0;
};
NumStored NumStoredIn(Connection& connection);
// Whether the sites, maps and obstacles of both have the same ids and stamps.
bool IsSame(Connection& a, Connection& b);
// Makes the sites, maps and obstacles of `to` those of `from`, in the caller's transaction.
void CopyAll(Connection& from, Connection& to);

// The number of the last change of the main database; 0 if none was ever stored.
int64_t LastChangeOf(Connection& main);
// Whether the copy has the number of the last change, also of one that is not committed.
bool IsInStep(Connection& main, Connection& copy);
// Whether the copy can follow by number. It keeps its place in the feed in its table follow_state.
bool CanFollow(Connection& main, Connection& copy);
// Brings the changes since the copy's place into the copy, also those that the open transaction on
// the main database has not committed. Only if CanFollow.
void FollowMain(Connection& main, Connection& copy);
// Writes into the copy that it is in step.
void SetInStep(Connection& main, Connection& copy);
// When the copy was written last, as 2026-01-31T12:00:00Z. Empty if it never was in step.
std::string InStepAt(Connection& copy);

}  // namespace freelsd
