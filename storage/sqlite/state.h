// The state that all stores share: the folder, both databases and the image files. Each database
// has one write connection and a pool of read connections.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "storage/box_cache.h"
#include "storage/boxes.h"
#include "storage/folder_lock.h"
#include "storage/image_files.h"
#include "storage/sqlite/reader_pool.h"
#include "storage/sqlite/site_queries.h"
#include "storage/sqlite/sqlite.h"
#include "storage/storage_error.h"

namespace freelsd {

// Thrown if the second copy of the sites is damaged.
struct CopyDamaged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

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
  // Opens or creates both databases, and makes their sites and obstacles equal.
  explicit StorageState(const std::filesystem::path& data_folder);
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
    if (is_copy_whole) {
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
  // Applies the same change of sites or maps to both databases, each in its own transaction. The
  // caller holds LockForWriting.
  template <typename Write>
  void WriteSites(Write write, Teller teller = Teller::kThisServer) {
    const VersionStep step(sites_version);
    WriteUnseen(write, teller);
  }

  // The same for a change that no reader sees: of maps that are not in force.
  template <typename Write>
  void WriteUnseen(Write write, Teller teller = Teller::kThisServer) {
    {
      Transaction transaction(writer);
      if (teller == Teller::kAbove) writer.Execute("UPDATE feed SET is_from_above = 1");
      write(writer);
      if (teller == Teller::kAbove) writer.Execute("UPDATE feed SET is_from_above = 0");
      transaction.Commit();
    }
    WriteCopy(write);
  }

  // The same for obstacles. obstacles_version increases even if a write fails.
  template <typename Write>
  void WriteObstacles(Write write, Teller teller = Teller::kThisServer) {
    const VersionStep step(obstacles_version);
    WriteSites(write, teller);
  }

  std::filesystem::path folder;
  FolderLock lock;
  // Guards notices.
  std::mutex notices_mutex;
  std::vector<std::string> notices;
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
  // True while the copy is undamaged and has every site of the main database.
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
  void WriteCopy(const std::function<void(const Connection&)>& write);
  void MarkCopyDamaged(const std::string& why);
  // Makes the sites and obstacles of both databases equal. Throws StorageError kDamaged if the main
  // database is damaged, CopyDamaged if the copy is.
  void BringTogether();
  void CheckWholeFiles();

  // A thread checks both files completely, once. Without the thread, this check would delay the
  // start too long.
  Connection check_connection_;
  Connection copy_check_connection_;
  std::atomic<bool> is_check_over_{false};
  std::thread check_thread_;
};

// Opens the folder. If a file is damaged, moves it aside and opens the folder without it.
std::unique_ptr<StorageState> OpenState(const std::filesystem::path& folder);

}  // namespace freelsd
