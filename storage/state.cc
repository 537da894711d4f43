#include "storage/state.h"

#include <chrono>
#include <set>

#include "storage/damage.h"
#include "storage/migrations.h"
#include "storage/site_rows.h"

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

// Creates the schema, or brings an older one up, in one transaction. True where it was created.
bool OpenSchema(const Connection& writer) {
  Statement statement = writer.Prepare("PRAGMA user_version");
  statement.Step();
  const int64_t version = statement.Int(0);
  if (version == kSchemaVersion) return false;
  if (version < 0 || version > kSchemaVersion) {
    throw StorageError("open the database",
                       "its schema has version " + std::to_string(version) +
                           ", this program understands up to " + std::to_string(kSchemaVersion));
  }
  Transaction transaction(writer);
  if (version == 0) {
    writer.Execute(kSchemaSql);
  } else {
    Migrate(writer, version);
  }
  writer.Execute(("PRAGMA user_version = " + std::to_string(kSchemaVersion)).c_str());
  transaction.Commit();
  return version == 0;
}

// A copy that cannot be read, or is of another version, is made anew.
std::filesystem::path UsableCopy(const std::filesystem::path& file) {
  try {
    const Connection copy(file, Access::kWrite);
    Statement version = copy.Prepare("PRAGMA user_version");
    version.Step();
    if (version.Int(0) == 0) return file;
    if (version.Int(0) == kSchemaVersion) {
      // What every start reads of it; a check of the whole file would take too long.
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

std::set<std::string> ImagesInUse(const Connection& writer) {
  std::set<std::string> images;
  Statement statement = writer.Prepare("SELECT DISTINCT sha256 FROM frames");
  while (statement.Step()) images.insert(statement.Text(0));
  return images;
}

}  // namespace

Storage::State::State(const std::filesystem::path& data_folder)
    : folder(MadeFolder(data_folder)),
      lock(folder),
      notices(SetAsideWhenDamaged(folder)),
      images(folder / "images"),
      writer(folder / kDatabaseName, Access::kWrite),
      readers(folder / kDatabaseName),
      copy_writer(UsableCopy(folder / kCopyName), Access::kWrite),
      copy_readers(folder / kCopyName),
      check_connection_(folder / kDatabaseName, Access::kRead) {
  const bool is_new = OpenSchema(writer);
  OpenSchema(copy_writer);
  if (is_new) {
    CopySites(copy_writer, writer);
  } else {
    CopySites(writer, copy_writer);
  }
  SyncFolder(folder);
  const std::set<std::string> in_use = ImagesInUse(writer);
  images.RemoveUnless([&in_use](const std::string& sha256) { return in_use.contains(sha256); });
  check_thread_ = std::thread([this] { CheckWholeFile(); });
}

Storage::State::~State() {
  // An interrupt that comes before the statement begins does nothing.
  while (!is_check_over_) {
    check_connection_.Interrupt();
    std::this_thread::sleep_for(kInterruptPeriod);
  }
  check_thread_.join();
}

std::unique_lock<std::mutex> Storage::State::LockForWriting() {
  std::unique_lock<std::mutex> write_lock(write_mutex);
  if (is_damaged) throw StorageError("write", "the database is damaged");
  return write_lock;
}

void Storage::State::MarkDamaged(const std::string& why) {
  if (is_damaged.exchange(true)) return;
  MarkForSettingAside(folder, why);
  const std::lock_guard notices_lock(notices_mutex);
  notices.push_back("the database is damaged (" + why +
                    "): sites are read from their second copy, nothing is written, and the next "
                    "start sets it aside");
}

void Storage::State::WriteCopy(const std::function<void(const Connection&)>& write) {
  try {
    Transaction transaction(copy_writer);
    write(copy_writer);
    transaction.Commit();
  } catch (const StorageError& error) {
    if (error.fault != StorageFault::kDamaged) throw;
    // The database itself is whole; the next start makes the copy anew.
    const std::lock_guard notices_lock(notices_mutex);
    const std::string notice = "the second copy of the sites is damaged";
    if (notices.empty() || notices.back() != notice) notices.push_back(notice);
  }
}

void Storage::State::CheckWholeFile() {
  try {
    Statement check = check_connection_.Prepare("PRAGMA quick_check(1)");
    if (check.Step() && check.Text(0) != "ok") MarkDamaged(check.Text(0));
  } catch (const StorageError& error) {
    // Anything else is an interrupt, or shows where it matters.
    if (error.fault == StorageFault::kDamaged) MarkDamaged(error.what());
  }
  is_check_over_ = true;
}

std::unique_ptr<Storage::State> Storage::Opened(const std::filesystem::path& folder) {
  try {
    return std::make_unique<State>(folder);
  } catch (const StorageError& error) {
    if (error.fault != StorageFault::kDamaged) throw;
    MarkForSettingAside(folder, error.what());
  }
  // The first try found it damaged; the second sets it aside.
  return std::make_unique<State>(folder);
}

}  // namespace freelsd
