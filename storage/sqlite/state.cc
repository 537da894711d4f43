#include "storage/sqlite/state.h"

#include <chrono>
#include <set>

#include "storage/sqlite/changes/changes.h"
#include "storage/sqlite/damage.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/obstacle_rows.h"
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

// Foreign keys are off while it lives. Must not begin or end within a transaction.
class WithoutForeignKeys {
 public:
  explicit WithoutForeignKeys(const Connection& connection) : connection_(connection) {
    connection_.Execute("PRAGMA foreign_keys = OFF");
  }
  ~WithoutForeignKeys() {
    try {
      connection_.Execute("PRAGMA foreign_keys = ON");
    } catch (const StorageError&) {
      // The connection is closed: opening the storage has failed.
    }
  }
  WithoutForeignKeys(const WithoutForeignKeys&) = delete;
  WithoutForeignKeys& operator=(const WithoutForeignKeys&) = delete;

 private:
  const Connection& connection_;
};

int64_t VersionOf(const Connection& connection) {
  Statement statement = connection.Prepare("PRAGMA user_version");
  statement.Step();
  return statement.Int(0);
}

// Creates the schema or migrates an older one, in one transaction. True if it was created.
bool OpenSchema(const Connection& writer) {
  const int64_t version = VersionOf(writer);
  if (version == kSchemaVersion) return false;
  if (version < 0 || version > kSchemaVersion) {
    throw StorageError("open the database",
                       "its schema has version " + std::to_string(version) +
                           ", this program supports versions up to " +
                           std::to_string(kSchemaVersion),
                       StorageFault::kNewer);
  }
  const WithoutForeignKeys without_foreign_keys(writer);
  Transaction transaction(writer);
  if (version == 0) {
    writer.Execute(kSchemaSql);
  } else {
    Migrate(writer, version);
  }
  writer.Execute(("PRAGMA application_id = " + std::to_string(ApplicationId(kSchemaVersion)) +
                  "; PRAGMA user_version = " + std::to_string(kSchemaVersion))
                     .c_str());
  transaction.Commit();
  return version == 0;
}

// The path of the copy. Removes a copy that cannot be read or is of a newer program; it is rebuilt.
// One of an older program is migrated as the database is: until that is known to be whole, the copy
// may be all that is left of the sites.
std::filesystem::path UsableCopy(const std::filesystem::path& folder, bool is_database_whole) {
  std::filesystem::path file = folder / kCopyName;
  if (TakeMarkOfCopy(folder) && is_database_whole) RemoveDatabase(file);
  try {
    const Connection copy(file, Access::kWrite);
    Statement version = copy.Prepare("PRAGMA user_version");
    version.Step();
    if (version.Int(0) == 0) return file;
    if (version.Int(0) > 0 && version.Int(0) <= kSchemaVersion) {
      // Reads only the columns that each start needs: checking the whole file takes too long.
      Statement ids = copy.Prepare("SELECT count(id), max(updated_at_us) FROM sites");
      ids.Step();
      return file;
    }
  } catch (const StorageError& error) {
    if (error.fault != StorageFault::kDamaged) throw;
  }
  RemoveDatabase(file);
  return file;
}

// Throws StorageError kDamaged unless `sql` gives "ok".
void ExpectOk(const Connection& connection, const char* sql) {
  Statement check = connection.Prepare(sql);
  if (!check.Step() || check.Text(0) == "ok") return;
  throw StorageError("check the database", check.Text(0), StorageFault::kDamaged);
}

// Throws StorageError kDamaged if a site is damaged. It leaves out maps: they are many times
// larger, and each map has a checksum that is compared when the map is read.
void CheckSites(const Connection& connection) {
  for (const char* table : {"sites", "site_numbers", "obstacles", "maps"}) {
    ExpectOk(connection, (std::string("PRAGMA integrity_check(") + table + ")").c_str());
  }
  ListObstacleRows(connection);
  CheckMapRows(connection);
  ExpectOk(connection, "SELECT rtreecheck('site_boxes')");
  CheckSiteRows(connection);
}

void CheckWhole(const Connection& connection) {
  ExpectOk(connection, "PRAGMA quick_check(1)");
  CheckSites(connection);
}

void MendBoxes(const Connection& writer) {
  Transaction transaction(writer);
  MendMapBoxes(writer);
  MendSiteBoxes(writer);
  transaction.Commit();
}

std::set<std::string> ImagesInUse(const Connection& writer) {
  std::set<std::string> images;
  Statement statement =
      writer.Prepare("SELECT sha256 FROM frames UNION SELECT sha256 FROM photo_tiles");
  while (statement.Step()) images.insert(statement.Text(0));
  return images;
}

}  // namespace

StorageState::StorageState(const std::filesystem::path& data_folder)
    : folder(MadeFolder(data_folder)),
      lock(folder),
      notices(SetAsideWhenDamaged(folder)),
      images(folder / "images"),
      writer(folder / kDatabaseName, Access::kWrite),
      readers(folder / kDatabaseName),
      copy_writer(UsableCopy(folder, notices.empty()), Access::kWrite),
      copy_readers(folder / kCopyName),
      check_connection_(folder / kDatabaseName, Access::kRead),
      copy_check_connection_(folder / kCopyName, Access::kRead) {
  BringTogether();
  SyncFolder(folder);
  const std::set<std::string> in_use = ImagesInUse(writer);
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
  const std::lock_guard notices_lock(notices_mutex);
  notices.push_back("the database is damaged (" + why +
                    "): sites are read from the second copy, nothing is written, and the next "
                    "start moves the database aside");
}

void StorageState::MarkCopyDamaged(const std::string& why) {
  if (!is_copy_whole.exchange(false)) return;
  // If this write fails, the next start has to detect the damage itself.
  MarkCopy(folder);
  const std::lock_guard notices_lock(notices_mutex);
  notices.push_back("the second copy of the sites is damaged (" + why +
                    "): sites are read from the database, and the next start rebuilds the copy");
}

void StorageState::WriteCopy(const std::function<void(const Connection&)>& write) {
  try {
    Transaction transaction(copy_writer);
    write(copy_writer);
    transaction.Commit();
  } catch (const StorageError& error) {
    const bool is_damage = error.fault == StorageFault::kDamaged;
    if (is_damage) MarkCopyDamaged(error.what());
    // The main database now has a change that the copy lacks.
    is_copy_whole = false;
    if (!is_damage) throw;
  }
}

void StorageState::BringTogether() {
  const bool is_new = OpenSchema(writer);
  first_map_number = FirstMapNumberOf(folder, folder / kDatabaseName, writer);
  const auto on_copy = [](const auto& act) {
    try {
      return act();
    } catch (const StorageError& error) {
      if (error.fault != StorageFault::kDamaged) throw;
      throw CopyDamaged(error.what());
    }
  };
  on_copy([&] {
    OpenSchema(copy_writer);
    // Without a feed it keeps no changes.
    copy_writer.Execute("DELETE FROM feed; DELETE FROM changes");
  });
  DeleteUnfinishedMaps(writer);
  on_copy([&] { DeleteUnfinishedMaps(copy_writer); });
  MendBoxes(writer);
  on_copy([&] { MendBoxes(copy_writer); });
  if (is_new) return on_copy([&] { CopySites(copy_writer, writer); });
  // The databases differ after a kill between two commits, but also after damage. The main database
  // is checked before its sites replace the copy's.
  const SiteStamps sites = StampsOf(writer);
  const auto obstacles = ObstacleStampsOf(writer);
  const MapStamps maps = MapStampsOf(writer);
  const bool is_same = on_copy([&] {
    return StampsOf(copy_writer) == sites && ObstacleStampsOf(copy_writer) == obstacles &&
           MapStampsOf(copy_writer) == maps;
  });
  if (is_same) return;
  CheckSites(writer);
  on_copy([&] { CopySites(writer, copy_writer); });
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

std::unique_ptr<StorageState> OpenState(const std::filesystem::path& folder) {
  // An attempt can detect one damaged file; the next attempt moves that file aside.
  constexpr int kNumFiles = 2;
  std::vector<std::string> notices;
  for (int i = 0; i < kNumFiles; ++i) {
    try {
      auto state = std::make_unique<StorageState>(folder);
      const std::lock_guard notices_lock(state->notices_mutex);
      state->notices.insert(state->notices.begin(), notices.begin(), notices.end());
      return state;
    } catch (const StorageError& error) {
      if (error.fault != StorageFault::kDamaged) throw;
      MarkForSettingAside(folder, error.what());
    } catch (const CopyDamaged& error) {
      SetCopyAside(folder);
      notices.push_back(std::string("the second copy of the sites was damaged (") + error.what() +
                        ") and was rebuilt from the database");
    }
  }
  return std::make_unique<StorageState>(folder);
}

}  // namespace freelsd
