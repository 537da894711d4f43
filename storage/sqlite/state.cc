#include "storage/sqlite/state.h"

#include <chrono>
#include <set>

#include "storage/sqlite/changes.h"
#include "storage/sqlite/schema.h"
#include "storage/sqlite/site_queries.h"
#include "storage/storage_error.h"

extern const char* const kSchemaSql;

namespace freelsd {
namespace {

constexpr std::chrono::milliseconds kInterruptPeriod{5};

std::filesystem::path MadeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  const bool is_new = std::filesystem::create_directories(folder, error);
  if (error) throw StorageError("create folder " + folder.string(), error.message());
  if (is_new) SyncFolder(std::filesystem::absolute(folder / ".").parent_path().parent_path());
  return folder;
}

// Creates the schema, in one transaction, unless it is there. True if it was created.
bool OpenSchema(Connection& writer) {
  const int64_t number = writer.Int("PRAGMA user_version");
  if (number == kSchemaNumber) return false;
  if (number != 0) throw OtherSchema("open the database", number, kSchemaNumber);
  Transaction transaction(writer);
  writer.Execute(kSchemaSql);
  writer.Execute("PRAGMA application_id = " + std::to_string(ApplicationId(kSchemaNumber)) +
                 "; PRAGMA user_version = " + std::to_string(kSchemaNumber));
  transaction.Commit();
  return true;
}

// Throws StorageError kDamaged unless `sql` gives "ok".
void ExpectOk(Connection& connection, const std::string& sql) {
  const auto found = connection.First([](const Row& row) { return row.Text(0); }, sql);
  if (!found || *found == "ok") return;
  throw StorageError("check the database", *found, StorageFault::kDamaged);
}

// Throws StorageError kDamaged if a site is damaged. It leaves out maps: they are many times
// larger, and each map has a checksum that is compared when the map is read.
void CheckSites(Connection& connection) {
  for (const char* table : {"sites", "site_numbers", "obstacles", "maps"}) {
    ExpectOk(connection, std::string("PRAGMA integrity_check(") + table + ")");
  }
  ListObstacleRows(connection);
  ForEachMapRow(connection, "", {}, [](const FlightMapRow&) {});
  ExpectOk(connection, "SELECT rtreecheck('site_boxes')");
  CheckSiteRows(connection);
}

void CheckWhole(Connection& connection) {
  ExpectOk(connection, "PRAGMA quick_check(1)");
  CheckSites(connection);
}

// False if the disk is full.
template <typename Act>
bool IsThereRoom(const Act& act) {
  try {
    act();
    return true;
  } catch (const StorageError& error) {
    if (error.fault != StorageFault::kFull) throw;
    return false;
  }
}

std::string Counted(int64_t number, const std::string& what) {
  return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

// "18 sites, 1 map and 3 obstacles were restored from the second copy, written last at ...".
std::string RestoredFrom(Connection& copy) {
  const NumStored num = NumStoredIn(copy);
  const std::string written_at = InStepAt(copy);
  return Counted(num.num_sites, "site") + ", " + Counted(num.num_maps, "map") + " and " +
         Counted(num.num_obstacles, "obstacle") + " were restored from the second copy" +
         (written_at.empty() ? "" : ", written last at " + written_at);
}

void DeleteUnfinishedMaps(Connection& writer) {
  // Usually there is none, and nothing is written.
  if (!writer.Has("SELECT 1 FROM maps WHERE is_in_force = 0 LIMIT 1")) return;
  writer.Execute("DELETE FROM maps WHERE is_in_force = 0");
}

}  // namespace

StorageState::StorageState(const std::filesystem::path& data_folder, const Log& given_log)
    : folder(MadeFolder(data_folder)),
      lock(folder),
      log(given_log),
      notices(folder / "notices", given_log),
      aside(SetAsideWhenDamaged(folder)),
      images(folder / "images"),
      writer(folder / kDatabaseName, Access::kWrite),
      readers(folder / kDatabaseName),
      copy_writer(folder / kCopyName, Access::kWrite),
      copy_readers(folder / kCopyName),
      check_connection_(folder / kDatabaseName, Access::kRead),
      copy_check_connection_(folder / kCopyName, Access::kRead) {
  BringTogether();
  // Unless there was no room to restore it yet.
  if (!is_damaged) TellOfSetAside();
  SyncFolder(folder);
  const std::vector<std::string> names =
      writer.Texts("SELECT sha256 FROM frames UNION SELECT sha256 FROM photo_tiles");
  const std::set<std::string> in_use(names.begin(), names.end());
  images.RemoveUnless([&in_use](const std::string& sha256) { return in_use.contains(sha256); });
  check_thread_ = std::thread([this] { CheckWholeFiles(); });
}

StorageState::~StorageState() {
  // Repeated, because an interrupt before the statement begins has no effect.
  while (!is_check_over_) {
    check_connection_.Interrupt();
    copy_check_connection_.Interrupt();
    std::this_thread::sleep_for(kInterruptPeriod);
  }
  check_thread_.join();
}

std::unique_lock<std::mutex> StorageState::LockForWriting() {
  std::unique_lock<std::mutex> write_lock(write_mutex);
  if (is_damaged) throw StorageError("write", "the database is damaged");
  return write_lock;
}

void StorageState::MarkDamaged(const std::string& why) {
  if (is_damaged.exchange(true)) return;
  MarkForSettingAside(folder, why);
  notices.AddForNow("the database is damaged (" + why +
                    "): sites are read from the second copy, nothing is written, and the next "
                    "start moves the database aside");
}

void StorageState::MarkCopyDamaged(const std::string& why) {
  const bool was_damaged = is_copy_damaged_.exchange(true);
  is_copy_whole = false;
  if (was_damaged) return;
  MarkCopy(folder, why);
  notices.AddForNow("the second copy of the sites is damaged (" + why +
                    "): sites are read from the database, and the next start makes the copy anew");
}

void StorageState::OpenSchemas() {
  const bool was_used = std::filesystem::exists(folder / kDatabaseFileName);
  OpenSchema(writer);
  // A forgotten flight may come again, and its maps that a cache knows must not have their ids
  // again.
  first_map_number = std::max(FirstMapNumberOf(folder, folder / kDatabaseName, writer),
                              writer.Int("SELECT 1 + coalesce(max(number), 0) FROM maps"));
  On(copy_writer, [&](Connection& copy) {
    if (OpenSchema(copy) && was_used && aside.IsEmpty() && LastChangeOf(writer) > 0) {
      notices.Add("the second copy of the sites was missing; it was made anew from the database");
    }
    // Without a feed it keeps no changes.
    copy.Execute("DELETE FROM feed; DELETE FROM changes; DELETE FROM photo_tiles");
  });
}

void StorageState::BringTogether() {
  OpenSchemas();
  for (Connection* each : {&writer, &copy_writer}) {
    // What is left of them takes room, but no reader sees it.
    (void)IsThereRoom([each] { On(*each, DeleteUnfinishedMaps); });
  }
  if (LastChangeOf(writer) == 0 && !Restore()) return;
  is_copy_whole = IsThereRoom([this] { CatchUp(); });
  if (!is_copy_whole && log) log("the second copy is behind the database: the disk is full");
}

bool StorageState::Restore() {
  const bool is_restored = IsThereRoom([this] {
    Transaction transaction(writer);
    CopyAll(copy_writer, writer);
    transaction.Commit();
  });
  if (is_restored) {
    restored_ = RestoredFrom(copy_writer);
    return true;
  }
  is_damaged = true;
  notices.AddForNow(
      "the disk has no room to restore the database from the second copy: sites are read from the "
      "copy, and nothing is written until a start with more room");
  return false;
}

// The databases differ after a kill between two commits, but also after damage. The main database
// is checked before anything but its numbered changes replaces what the copy holds.
void StorageState::CatchUp() {
  Transaction transaction(copy_writer);
  FollowInCopy();
  MakeCopyEqual();
  transaction.Commit();
}

void StorageState::FollowInCopy() {
  if (CanFollow(writer, copy_writer)) {
    FollowMain(writer, copy_writer);
  } else {
    MakeCopyEqual();
  }
  SetInStep(writer, copy_writer);
}

void StorageState::MakeCopyEqual() {
  if (IsSame(writer, copy_writer)) return;
  CheckSites(writer);
  CopyAll(writer, copy_writer);
}

void StorageState::TellOfSetAside() {
  if (aside.IsEmpty()) return;
  std::string text = aside.database;
  if (!aside.copy.empty()) text += (text.empty() ? "" : "; ") + aside.copy;
  if (aside.database.empty()) {
    text += is_copy_whole ? "; it was made anew from the database"
                          : "; it will be made anew from the database when the disk has room";
  } else if (aside.copy.empty()) {
    text += "; " + (restored_.empty() ? "its sites were restored from the second copy" : restored_);
  } else {
    text += "; nothing could be restored";
  }
  notices.Add(text);
  ForgetSetAside(folder);
}

void StorageState::CheckWholeFiles() {
  // Other failures are ignored: an interrupt, or a fault that the next use reports.
  try {
    CheckWhole(copy_check_connection_);
  } catch (const StorageError& error) {
    if (error.fault == StorageFault::kDamaged) MarkCopyDamaged(error.what());
  }
  try {
    CheckWhole(check_connection_);
  } catch (const StorageError& error) {
    if (error.fault == StorageFault::kDamaged) MarkDamaged(error.what());
  }
  is_check_over_ = true;
}

std::unique_ptr<StorageState> OpenState(const std::filesystem::path& folder,
                                        const StorageState::Log& log) {
  // An attempt can detect one damaged file; the next attempt moves that file aside.
  constexpr int kNumFiles = 2;
  for (int i = 0; i < kNumFiles; ++i) {
    try {
      return std::make_unique<StorageState>(folder, log);
    } catch (const StorageError& error) {
      if (error.fault != StorageFault::kDamaged) throw;
      MarkForSettingAside(folder, error.what());
    } catch (const CopyDamaged& error) {
      MarkCopy(folder, error.what());
    }
  }
  return std::make_unique<StorageState>(folder, log);
}

}  // namespace freelsd
