// Durable storage of flights, frames, images, jobs, telemetry, obstacles, sites and maps, as rows,
// JSON text and blobs. Does not depend on engine types. This is the only public header of storage/;
// it also gives MbTiles, which reads map tiles of others.
//
// The rows are in SQLite databases in a folder, or in a PostgreSQL database that several processes
// share. When a call returns, its data are on disk (SQLite: WAL, synchronous=FULL; PostgreSQL:
// synchronous_commit=on). An image file and its folder are synced before a row that refers to the
// image is committed. Readers never wait for a writer. All methods are thread-safe.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "storage/change_store.h"
#include "storage/claim_store.h"
#include "storage/flight_store.h"
#include "storage/frame_store.h"
#include "storage/image_store.h"
#include "storage/job_store.h"
#include "storage/map_store.h"
#include "storage/mbtiles.h"
#include "storage/notices.h"
#include "storage/obstacle_store.h"
#include "storage/site_store.h"
#include "storage/storage_error.h"
#include "storage/telemetry_store.h"

namespace freelsd {

class StorageBackend;

enum class DatabaseKind { kSqlite, kPostgres };

// Where a storage is.
struct StorageOptions {
  // Folder of this process alone: its uploads, and with SQLite also the databases and the images.
  std::filesystem::path folder;
  // PostgreSQL: URI as libpq reads it, without a password. Empty: SQLite.
  std::string database_url;
  // PostgreSQL: folder of the images, which all processes on the same database share.
  std::filesystem::path images_folder;
  // PostgreSQL: whether other processes may use the database at the same time. Otherwise a second
  // process is refused, and one that lost the database for a while, so that another took it, writes
  // nothing any more.
  bool is_shared = false;
  // A shared database: whether this process works on flights (ClaimStore), and how long others wait
  // for a sign of it until they take its flights.
  bool is_worker = false;
  double lease_s = 8.0;
  // PostgreSQL: most connections at the same time, longest statement, longest wait for a connection
  // or for the database to come back, and how old an image must be to be removed at a start because
  // no row refers to it.
  int max_num_connections = 16;
  double statement_timeout_s = 30.0;
  double connection_timeout_s = 5.0;
  double unused_image_age_s = 86400.0;
  // Gets the text of each new notice, for the log. Any thread may call it.
  std::function<void(const std::string& text)> log_notice = {};
};

// Connections to PostgreSQL that this process keeps for one purpose.
struct PoolState {
  // 'readers' or 'writers'.
  std::string name;
  int num_open = 0;
  int num_in_use = 0;
  int max_num_connections = 0;
  // Since the start: how often all were in use, and how long one was waited for.
  int64_t num_waits = 0;
  double waited_s = 0.0;
};

// See Storage::HoldVersions.
class VersionHold {
 public:
  virtual ~VersionHold() = default;
  VersionHold(const VersionHold&) = delete;
  VersionHold& operator=(const VersionHold&) = delete;

 protected:
  VersionHold() = default;
};

class Storage {
  // Declared before the stores, because they refer to it.
  std::unique_ptr<StorageBackend> backend_;

 public:
  // SQLite: opens the folder, or creates it with the database. Removes image files that no frame
  // refers to. A second copy of sites, maps and obstacles, in a database of its own, follows the
  // main database. Damaged databases are moved aside, the main one together with its images; a new
  // one then starts with what the second copy holds. A notice says so. Throws StorageError and
  // changes nothing if another process uses the folder, or a database in it has a schema of another
  // number.
  explicit Storage(const std::filesystem::path& folder);
  // PostgreSQL, if options.database_url is given: creates the schema if there is none. Throws
  // StorageError and changes nothing if the database cannot be reached, another process uses the
  // folder or the database, or the schema has another number.
  explicit Storage(const StorageOptions& options);
  ~Storage();

  FlightStore& flights;
  FrameStore& frames;
  ImageStore& images;
  JobStore& jobs;
  TelemetryStore& telemetry;
  SiteStore& sites;
  MapStore& maps;
  ObstacleStore& obstacles;
  ClaimStore& claims;
  ChangeStore& changes;

  DatabaseKind Kind() const;
  // Folder for uploads that are not acknowledged yet. Opening the storage empties it.
  std::filesystem::path SpoolFolder() const;
  // The reason why the storage cannot be written to now: damage, little free disk space, or a
  // failing write. Nothing if it can be written to.
  std::optional<std::string> WhyNotWritable() const;
  // Reports that the main database is damaged. After this call this process writes nothing. SQLite:
  // sites are read from the second copy, and the next start moves the database aside.
  void MarkDamaged(const std::string& why) const;
  // What the operator must know, above all about damage; oldest first, with those that are
  // acknowledged.
  std::vector<Notice> ListNotices() const;
  // What was not acknowledged yet.
  std::vector<std::string> Notices() const;
  // False if there is no such notice.
  bool AcknowledgeNotice(const std::string& id) const;
  // Empty with SQLite.
  std::vector<PoolState> Pools() const;
  // For an answer that asks for sites and maps many times: while the returned object lives, this
  // thread takes the versions of sites and obstacles (SiteStore::Version) as they are now. The
  // answer is then as of this call, or later. The object must stay in this thread. Nothing with
  // SQLite, where a version costs nothing.
  std::unique_ptr<VersionHold> HoldVersions() const;

 private:
  explicit Storage(std::unique_ptr<StorageBackend> backend);
};

}  // namespace freelsd
