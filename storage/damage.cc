#include "storage/damage.h"

#include <fstream>
#include <iterator>
#include <optional>

#include "storage/migrations.h"
#include "storage/sqlite.h"

namespace freelsd {
namespace {

constexpr char kMarkName[] = "damaged";
// More versions of the schema than there will ever be.
constexpr int64_t kMaxVersionsAhead = 1000;
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
  // The copy is brought up last: where it is ahead, the file is not what it was. A newer one is
  // another program's, and refused, unless no program will ever write that number.
  const int64_t number = version.value_or(0);
  const bool can_be_newer = number >= kSchemaVersion && number < kSchemaVersion + kMaxVersionsAhead;
  if (VersionOfCopy(folder) != kSchemaVersion || can_be_newer) return std::nullopt;
  return version ? "its version is not that of its copy" : "its file is gone";
}

void Move(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (std::filesystem::exists(from)) std::filesystem::rename(from, to);
}

}  // namespace

void MarkForSettingAside(const std::filesystem::path& folder, const std::string& why) {
  // Where not even this can be written, the next start finds the damage itself.
  std::ofstream(folder / kMarkName) << why;
}

std::vector<std::string> SetAsideWhenDamaged(const std::filesystem::path& folder) {
  const std::optional<std::string> why = WhyDamaged(folder);
  if (!why) return {};
  std::string name = "damaged-1";
  for (int i = 2; std::filesystem::exists(folder / name); ++i) {
    name = "damaged-" + std::to_string(i);
  }
  std::filesystem::create_directory(folder / name);
  for (const char* suffix : kSuffixes) {
    const std::string file = std::string(kDatabaseName) + suffix;
    Move(folder / file, folder / name / file);
  }
  Move(folder / "images", folder / name / "images");
  std::filesystem::remove(folder / kMarkName);
  return {"the database was damaged (" + *why + "); it and the images lie in " + name +
          " now, and the sites come from their second copy"};
}

void RemoveDatabase(const std::filesystem::path& file) {
  for (const char* suffix : kSuffixes) std::filesystem::remove(file.string() + suffix);
}

}  // namespace freelsd
