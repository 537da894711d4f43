// The state that all stores share: the folder, both databases and the image files. Each database
// has one write connection and a pool of read connections.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "storage/box_cache.h"
#include "storage/boxes.h"
#include "storage/folder_lock.h"
#include "storage/image_files.h"
#include "storage/notices.h"
#include "storage/sqlite/damage.h"
#include "storage/sqlite/reader_pool.h"
#include "storage/sqlite/site_queries.h"
#include "storage/sqlite/sqlite.h"
#include "storage/storage_error.h"

namespace freelsd {

// Whose change it is: kAbove, if the server that this one follows told it.
enum class Teller { kThisServer, kAbove };

// Its destructor increases the version, whether the change succeeded or failed.
class VersionStep {
 public:
  explicit VersionStep(std::atomic<uint64_t>& version) : version_(version) {}
  ~VersionStep() { ++version_; }
  VersionStep(const VersionStep&) = delete;
  VersionStep& operator=(const VersionStep&) = delete;

 private:
  std::atomic<uint64_t>& version_;
};

// The open data folder. Thread-safe: readers come from pools, and writers hold LockForWriting.
struct StorageState {
  using Log = std::function<void(const std::string& text)>;
  using Write = std::function<void(const Connection& connection)>;

  // Opens or creates both databases, and brings the copy in step.
  StorageState(const std::filesystem::path& data_folder, const Log& given_log);
  ~StorageState();

  // Throws StorageError if the main database is damaged.
  std::unique_lock<std::mutex> LockForWriting();
  void MarkDamaged(const std::string& why);
  // Reads from the main database, or from the copy if the main database is damaged. Never waits for
  // the writer.
  template <typename Read>
  auto ReadSites(Read read) {
    if (!is_damaged) {
      try {
        const Reader reader(readers);
        return read(*reader);
      } catch (const StorageError& error) {
        if (error.fault != StorageFault::kDamaged) throw;
        MarkDamaged(error.what());
      }
    }
    const Reader reader(copy_readers);
    return read(*reader);
  }
  // Reads the rows within the box through the cache, each once. The box may cross the antimeridian.
  template <typename Row>
  SharedRows<Row> RowsWithin(BoxCache<Row>& cache,
                             const BoundingBox& box,
                             typename BoxCache<Row>::Rows (*list)(const Connection&,
                                                                  const BoundingBox&)) {
    return freelsd::RowsWithin<Row>(cache, box, sites_version, [&](const BoundingBox& wide) {
      return ReadForRecall([&](const Connection& connection) { return list(connection, wide); });
    });
  }
  // Reads from the copy, or from the main database if the copy is damaged. Recall uses this
  // function, because damage can remove rows from the main database undetected, and the copy is a
  // separate file.
  template <typename Read>
  auto ReadForRecall(Read read) {
    if (is_copy_whole && !is_copy_damaged_) {
      try {
        const Reader reader(copy_readers);
        return read(*reader);
      } catch (const StorageError& error) {
        if (error.fault != StorageFault::kDamaged) throw;
        MarkCopyDamaged(error.what());
      }
    }
    return ReadSites(read);
  }
  // Finds one site in the main database, else in the copy. Damage may have removed the site from
  // the main database undetected.
  template <typename Find>
  auto FindOfSite(Find find) {
    auto found = ReadSites(find);
    return found ? found : ReadForRecall(find);
  }
  // Changes sites, maps or obstacles in the main database in one commit, which decides; the copy
  // follows. The copy's part is on disk before that commit, so that a full disk refuses both or
  // none. A kill between the two commits leaves the copy behind until the next start. The caller
  // holds LockForWriting.
  void WriteSites(const Write& write, Teller teller = Teller::kThisServer);
  // Writes rows of maps that are not in force, which no reader sees, to both databases.
  void WriteUnseen(const Write& write);
  // As WriteSites. obstacles_version increases even if a write fails.
  void WriteObstacles(const Write& write, Teller teller = Teller::kThisServer) {
    const VersionStep step(obstacles_version);
    WriteSites(write, teller);
  }

  std::filesystem::path folder;
  FolderLock lock;
  Log log;
  NoticeBoard notices;
  // Done before any file is opened.
  SetAside aside;
  ImageFiles images;
  // Guards the turn to change sites. Taken before write_mutex.
  std::mutex turns_mutex;
  // Guards writer and copy_writer.
  std::mutex write_mutex;
  Connection writer;
  ReaderPool readers;
  // The second copy, which holds only sites, obstacles and maps.
  Connection copy_writer;
  ReaderPool copy_readers;
  std::atomic<bool> is_damaged{false};
  // True while the copy is undamaged and has all that the main database has committed.
  std::atomic<bool> is_copy_whole{true};
  // Increases when any site or obstacle changes.
  std::atomic<uint64_t> sites_version{1};
  // Increases when any obstacle changes.
  std::atomic<uint64_t> obstacles_version{1};
  BoxCache<RecallRow> recall_rows;
  BoxCache<MapRow> map_rows;
  BoxCache<std::string> overruled_ids;
  // Guards bounds_version and bounds.
  std::mutex bounds_mutex;
  uint64_t bounds_version = 0;
  RecallBounds bounds;
  // By flight. Guarded by write_mutex.
  std::map<std::string, int64_t> last_map_numbers;
  int64_t first_map_number = 1;

 private:
  void MarkCopyDamaged(const std::string& why);
  // At the start. Throws StorageError kDamaged if the main database is damaged, CopyDamaged if the
  // copy is.
  void BringTogether();
  void OpenSchemas();
  // Fills a new main database from the copy. False if there is no room: recall reads the copy then,
  // and the next start tries again.
  bool Restore();
  void CatchUp();
  // Within transactions on both: brings what the copy lacks into it.
  void FollowInCopy();
  void MakeCopyEqual();
  // The copy with all changes of the open transaction on the main database, ready to commit.
  // Nothing if the copy is damaged, or lacks nothing.
  std::unique_ptr<Transaction> PrepareCopy();
  void TellOfSetAside();
  void CheckWholeFiles();

  std::atomic<bool> is_copy_damaged_{false};
  // What this start restored, for a notice; empty: nothing.
  std::string restored_;

  // A thread checks both files completely, once. Without the thread, this check would delay the
  // start too long.
  Connection check_connection_;
  Connection copy_check_connection_;
  std::atomic<bool> is_check_over_{false};
  std::thread check_thread_;
};

// Opens the folder. If a file is damaged, moves it aside and opens the folder without it.
std::unique_ptr<StorageState> OpenState(const std::filesystem::path& folder,
                                        const StorageState::Log& log);

}  // namespace freelsd
