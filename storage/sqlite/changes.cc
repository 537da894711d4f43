#include "storage/sqlite/changes.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <sys/stat.h>

#include "storage/storage_error.h"

namespace freelsd {
namespace {

// More maps than a flight gets between a backup and its return.
constexpr int64_t kMapsOfRestore = 1000000;

struct DatabaseFile {
  uint64_t device = 0;
  uint64_t inode = 0;
  int64_t num_restores = 0;
};

DatabaseFile FileAt(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) throw StorageError("stat", std::strerror(errno));
  return {status.st_dev, status.st_ino, 0};
}

}  // namespace

int64_t FirstMapNumberOf(const std::filesystem::path& folder,
                         const std::filesystem::path& database,
                         Connection& writer) {
  DatabaseFile now = FileAt(database);
  DatabaseFile before;
  std::ifstream known(folder / kDatabaseFileName);
  const bool is_first = !known.is_open();
  known >> before.device >> before.inode >> before.num_restores;
  const bool is_same = known && before.device == now.device && before.inode == now.inode;
  now.num_restores = before.num_restores + (is_first || is_same ? 0 : 1);
  if (!is_first && !is_same) writer.Execute("UPDATE feed SET id = lower(hex(randomblob(8)))");
  if (!is_same) {
    std::ofstream(folder / kDatabaseFileName)
        << now.device << ' ' << now.inode << ' ' << now.num_restores << '\n';
  }
  return 1 + kMapsOfRestore * now.num_restores;
}

}  // namespace freelsd
