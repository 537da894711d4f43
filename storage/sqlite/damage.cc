#include "storage/sqlite/damage.h"

#include <fstream>
#include <iterator>
#include <optional>

#include "storage/sqlite/migrations.h"
#include "storage/sqlite/sqlite.h"
#include "storage/storage_error.h"

namespace freelsd {
namespace {

constexpr char kMarkName[] = "damaged";
constexpr char kCopyMarkName[] = "damaged-copy";
constexpr const char* kSuffixes[] = {"", "-wal", "-shm"};

struct Stamp {
  int64_t version = 0;
  int64_t application_id = 0;
};

int64_t NumberOf(const Connection& connection, const char* sql) {
  Statement statement = connection.Prepare(sql);
  statement.Step();
  return statement.Int(0);
}

// Nothing if the file does not exist.
std::optional<Stamp> StampOf(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  const Connection connection(file, Access::kWrite);
  NumberOf(connection, "SELECT count(*) FROM sqlite_schema");
  return Stamp{NumberOf(connection, "PRAGMA user_version"),
               NumberOf(connection, "PRAGMA application_id")};
}

std::optional<int64_t> VersionOf(const std::filesystem::path& file) {
  const std::optional<Stamp> stamp = StampOf(file);
  return stamp ? std::optional(stamp->version) : std::nullopt;
}

// Also nothing if the copy cannot be read, because it then proves nothing about the database.
std::optional<int64_t> VersionOfCopy(const std::filesystem::path& folder) {
  try {
    return VersionOf(folder / kCopyName);
  } catch (const StorageError&) {
    return std::nullopt;
  }
}

// Checks both files: a newer program may have been killed after it migrated one of them.
void RefuseNewer(const std::filesystem::path& folder) {
  for (const char* name : {kDatabaseName, kCopyName}) {
    std::optional<Stamp> stamp;
    try {
      stamp = StampOf(folder / name);
    } catch (const StorageError& error) {
      if (error.fault != StorageFault::kDamaged) throw;
    }
    if (!stamp || stamp->version <= kSchemaVersion) continue;
    if (stamp->application_id != ApplicationId(stamp->version)) continue;
    throw StorageError("open " + (folder / name).string(),
                       "a newer freelsd wrote it: its schema has version " +
                           std::to_string(stamp->version) +
                           ", this program supports versions up to " +
                           std::to_string(kSchemaVersion) + "; nothing was changed",
                       StorageFault::kNewer);
  }
}

std::optional<std::string> WhyDamaged(const std::filesystem::path& folder) {
  if (std::ifstream mark(folder / kMarkName); mark) {
    return std::string(std::istreambuf_iterator<char>(mark), {});
  }
  std::optional<int64_t> version;
  try {
    version = VersionOf(folder / kDatabaseName);
  } catch (const StorageError& error) {
    if (error.fault != StorageFault::kDamaged) throw;
    return error.what();
  }
  // The copy is migrated after the database. If only the copy has this program's version, the
  // database was lost or replaced. Files of a newer program were refused before.
  if (version == kSchemaVersion || VersionOfCopy(folder) != kSchemaVersion) return std::nullopt;
  return version ? "its schema version differs from its copy's" : "its file is missing";
}

void Move(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (std::filesystem::exists(from)) std::filesystem::rename(from, to);
}

// Creates a folder with an unused name and returns the name.
std::string NewPlace(const std::filesystem::path& folder) {
  std::string name = "damaged-1";
  for (int i = 2; std::filesystem::exists(folder / name); ++i) {
    name = "damaged-" + std::to_string(i);
  }
  std::filesystem::create_directory(folder / name);
  return name;
}

void MoveDatabase(const std::filesystem::path& folder,
                  const std::string& database,
                  const std::string& place) {
  for (const char* suffix : kSuffixes) {
    const std::string file = database + suffix;
    Move(folder / file, folder / place / file);
  }
}

}  // namespace

void MarkForSettingAside(const std::filesystem::path& folder, const std::string& why) {
  // If this write fails, the next start has to detect the damage itself.
  std::ofstream(folder / kMarkName) << why;
}

void MarkCopy(const std::filesystem::path& folder) { std::ofstream(folder / kCopyMarkName) << ""; }

bool TakeMarkOfCopy(const std::filesystem::path& folder) {
  std::error_code error;
  return std::filesystem::remove(folder / kCopyMarkName, error);
}

std::vector<std::string> SetAsideWhenDamaged(const std::filesystem::path& folder) {
  RefuseNewer(folder);
  const std::optional<std::string> why = WhyDamaged(folder);
  if (!why) return {};
  const std::string name = NewPlace(folder);
  MoveDatabase(folder, kDatabaseName, name);
  Move(folder / "images", folder / name / "images");
  std::filesystem::remove(folder / kMarkName);
  return {"the database was damaged (" + *why + "); it was moved to " + name +
          " together with the images, and the sites were restored from the second copy"};
}

void SetCopyAside(const std::filesystem::path& folder) {
  MoveDatabase(folder, kCopyName, NewPlace(folder));
}

void RemoveDatabase(const std::filesystem::path& file) {
  for (const char* suffix : kSuffixes) std::filesystem::remove(file.string() + suffix);
}

}  // namespace freelsd
