// What Storage's methods share: the write connection behind its mutex, and the readers' pool.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "storage/box_cache.h"
#include "storage/image_files.h"
#include "storage/site_rows.h"
#include "storage/sqlite.h"
#include "storage/storage.h"

namespace freelsd {

// Exclusive for this process while it lives.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

// Read connections, as many as are used at once; each is given back at the end of its Reader.
class ReaderPool {
 public:
  explicit ReaderPool(const std::filesystem::path& database_file) : file_(database_file) {}
  std::unique_ptr<Connection> Take();
  void GiveBack(std::unique_ptr<Connection> connection);

 private:
  std::filesystem::path file_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Connection>> idle_;
};

class Reader {
 public:
  explicit Reader(ReaderPool& pool) : pool_(pool), connection_(pool.Take()) {}
  ~Reader() { pool_.GiveBack(std::move(connection_)); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  const Connection* operator->() const { return connection_.get(); }
  const Connection& operator*() const { return *connection_; }

 private:
  ReaderPool& pool_;
  std::unique_ptr<Connection> connection_;
};

// The sites' second copy is not what was written.
struct CopyDamaged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Storage::State {
  // Opens or creates both databases and brings them to one state.
  explicit State(const std::filesystem::path& data_folder);
  ~State();

  // Throws StorageError where the database is damaged.
  std::unique_lock<std::mutex> LockForWriting();
  void MarkDamaged(const std::string& why);
  // From the database, or from the sites' second copy where it is damaged. Waits for no writer.
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
  // Through the cache; both halves of a box that crosses the antimeridian.
  template <typename Row>
  SharedRows<Row> RowsWithin(BoxCache<Row>& cache,
                             const BoundingBox& box,
                             typename BoxCache<Row>::Rows (*list)(const Connection&,
                                                                  const BoundingBox&)) {
    const uint64_t version = sites_version;
    SharedRows<Row> rows;
    for (const BoundingBox& part : PlainBoxes(box)) {
      SharedRows<Row> some = cache.Within(part, version, [&](const BoundingBox& wide) {
        return ReadForRecall([&](const Connection& connection) { return list(connection, wide); });
      });
      std::move(some.begin(), some.end(), std::back_inserter(rows));
    }
    return rows;
  }
  // What recall looks through. From the copy, which nobody else reads and whose damage does not
  // come with the database's: a row that is lost there without a trace would be lost to recall.
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
  // Of one site: what the database lost without a trace, the copy still has.
  template <typename Find>
  auto FindOfSite(Find find) {
    auto found = ReadSites(find);
    return found ? found : ReadForRecall(find);
  }
  // The same change of sites in both, each in a transaction.
  template <typename Write>
  void WriteSites(Write write) {
    {
      Transaction transaction(writer);
      write(writer);
      transaction.Commit();
    }
    WriteCopy(write);
  }

  std::filesystem::path folder;
  FolderLock lock;
  std::mutex notices_mutex;
  std::vector<std::string> notices;
  ImageFiles images;
  std::mutex write_mutex;
  Connection writer;
  ReaderPool readers;
  // Sites alone, a second time.
  Connection copy_writer;
  ReaderPool copy_readers;
  std::atomic<bool> is_damaged{false};
  // And has every site that the database has.
  std::atomic<bool> is_copy_whole{true};
  // Changes when any site does.
  std::atomic<uint64_t> sites_version{1};
  BoxCache<RecallRow> recall_rows;
  BoxCache<Storage::MapRow> map_rows;
  std::mutex bounds_mutex;
  uint64_t bounds_version = 0;
  RecallBounds bounds;

 private:
  void WriteCopy(const std::function<void(const Connection&)>& write);
  void MarkCopyDamaged(const std::string& why);
  // Throws StorageError kDamaged where the database is, CopyDamaged where the copy is.
  void BringTogether();
  void CheckWholeFiles();

  // Read both whole once, beside everything else: at start it would take too long.
  Connection check_connection_;
  Connection copy_check_connection_;
  std::atomic<bool> is_check_over_{false};
  std::thread check_thread_;
};

}  // namespace freelsd
