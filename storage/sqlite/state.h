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

#include "storage/database.h"
#include "storage/folder_lock.h"
#include "storage/image_files.h"
#include "storage/notices.h"
#include "storage/sqlite/damage.h"
#include "storage/sqlite/reader_pool.h"
#include "storage/sqlite/sqlite.h"
#include "storage/storage_error.h"

namespace freelsd {

// The open data folder. Thread-safe: readers come from pools, and writers hold LockForWriting.
struct StorageState final : public StoreAccess {
  using Log = std::function<void(const std::string& text)>;

  // Opens or creates both databases, and brings the copy in step.
  StorageState(const std::filesystem::path& data_folder, const Log& given_log);
  ~StorageState() override;

  const Dialect& dialect() const override;
  bool HasImage(const std::string& sha256) const override { return images.Has(sha256); }
  uint64_t SitesVersion() override { return sites_version; }
  uint64_t ObstaclesVersion() override { return obstacles_version; }
  std::unique_ptr<Turn> TakeTurn() override;
  int64_t NextMapNumber(const std::string& flight_id) override;

  // Throws StorageError if the main database is damaged.
  std::unique_lock<std::mutex> LockForWriting();
  void MarkDamaged(const std::string& why);
  // Whether a frame or a photo tile needs the image file. The caller holds LockForWriting.
  bool IsImageNeeded(const std::string& sha256);

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
  // By flight. Guarded by write_mutex.
  std::map<std::string, int64_t> last_map_numbers;
  int64_t first_map_number = 1;

 private:
  using Act = std::function<void(Writer& writer)>;

  // Never waits for the writer.
  void ReadWith(Reading from, const std::function<void(Database&)>& act) override;
  void ReadSites(const std::function<void(Database&)>& act);
  void WriteWith(Writing what, Teller teller, const Act& act) override;
  // Changes sites, maps or obstacles in the main database in one commit, which decides; the copy
  // follows. The copy's part is on disk before that commit, so that a full disk refuses both or
  // none. A kill between the two commits leaves the copy behind until the next start. The caller
  // holds LockForWriting.
  void WriteSites(Writer& own, Teller teller, const Act& act);
  // Writes rows of maps that are not in force to both databases.
  void WriteUnseen(Writer& own, const Act& act);
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
