#include "storage/damage.h"

#include <fstream>
#include <iterator>
#include <optional>

#include "storage/migrations.h"
#include "storage/sqlite.h"

namespace freelsd {
namespace {

constexpr char kMarkName[] = "damaged";
constexpr char kCopyMarkName[] = "damaged-copy";
constexpr const char* kSuffixes[] = {"", "-wal", "-shm"};

// Nothing where the file is not there.
std::optional<int64_t> VersionOf(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  const Connection connection(file, Access::kWrite);
  Statement tables = connection.Prepare("SELECT count(*) FROM sqlite_schema");
  tables.Step();
  Statement version = connection.Prepare("PRAGMA user_version");
  version.Step();
  return version.Int(0);
}

// Nothing also where it cannot be read: then it is of no help.
std::optional<int64_t> VersionOfCopy(const std::filesystem::path& folder) {
  try {
    return VersionOf(folder / kCopyName);
  } catch (const StorageError&) {
    return std::nullopt;
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
  // The copy is brought up last: where it is of this version and the file of another, the file is
  // not what it was. A newer program would have left a newer copy too.
  if (version == kSchemaVersion || VersionOfCopy(folder) != kSchemaVersion) return std::nullopt;
  return version ? "its version is not that of its copy" : "its file is gone";
}

void Move(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (std::filesystem::exists(from)) std::filesystem::rename(from, to);
}

// The name of a new folder.
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
  // Where not even this can be written, the next start finds the damage itself.
  std::ofstream(folder / kMarkName) << why;
}

void MarkCopy(const std::filesystem::path& folder) { std::ofstream(folder / kCopyMarkName) << ""; }

bool TakeMarkOfCopy(const std::filesystem::path& folder) {
  std::error_code error;
  return std::filesystem::remove(folder / kCopyMarkName, error);
}

std::vector<std::string> SetAsideWhenDamaged(const std::filesystem::path& folder) {
  const std::optional<std::string> why = WhyDamaged(folder);
  if (!why) return {};
  const std::string name = NewPlace(folder);
  MoveDatabase(folder, kDatabaseName, name);
  Move(folder / "images", folder / name / "images");
  std::filesystem::remove(folder / kMarkName);
  return {"the database was damaged (" + *why + "); it and the images lie in " + name +
          " now, and the sites come from their second copy"};
}

void SetCopyAside(const std::filesystem::path& folder) {
  MoveDatabase(folder, kCopyName, NewPlace(folder));
}

void RemoveDatabase(const std::filesystem::path& file) {
  for (const char* suffix : kSuffixes) std::filesystem::remove(file.string() + suffix);
}

}  // namespace freelsd
