// The state that all stores share: pools of connections, the image files, and caches for recall.
// Each organisation has stores and a state of its own, so that no cache is common to two.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "storage/box_cache.h"
#include "storage/folder_lock.h"
#include "storage/image_files.h"
#include "storage/postgres/organisations/organisations.h"
#include "storage/postgres/ownership.h"
#include "storage/postgres/pool.h"
#include "storage/postgres/registration.h"
#include "storage/storage.h"

namespace freelsd {

// What this process has of the database. Thread-safe. Readers and writers have pools of their own,
// so that readers never wait for writers.
struct PostgresProcess {
  // Opens the database and creates its schema if it has none.
  explicit PostgresProcess(const StorageOptions& given);

  // Throws StorageError after MarkDamaged.
  ConnectionPool& Writers();
  void MarkDamaged(const std::string& why);
  // The version of 'sites' or 'obstacles'.
  uint64_t VersionOf(const std::string& name);

  StorageOptions options;
  FolderLock lock;
  ConnectionPool readers;
  ConnectionPool writers;
  // Of one connection.
  ConnectionPool owner_pool;
  // The same, for `listener`: it hears when others tell something. Empty until it is needed, and
  // after the connection broke. Only the thread that calls ListTold uses it.
  ConnectionPool listener_pool;
  std::optional<ConnectionLease> listener;
  // Set once the schema is there.
  std::optional<Ownership> ownership;
  // Empty unless this process is a worker on a shared database.
  std::optional<Registration> registration;
  // Of this process, for the others.
  std::string origin;
  std::atomic<bool> is_damaged{false};
  // Guards the turn to change sites, within this process.
  std::mutex turns_mutex;
  // None outlasts the process: it finds again what its start finds.
  NoticeBoard notices;
};

// While it lives, its thread is told these versions, and does not ask the database again.
class HeldVersions : public VersionHold {
 public:
  explicit HeldVersions(PostgresProcess& process);
  ~HeldVersions() override;
  // Nothing if this thread holds no versions of the process.
  static std::optional<uint64_t> Find(const PostgresProcess& process, const std::string& name);

 private:
  const PostgresProcess& process_;
  const HeldVersions* before_;
  std::map<std::string, uint64_t> versions_;
};

// What is an organisation's. Thread-safe.
struct PostgresState {
  PostgresState(std::shared_ptr<PostgresProcess> opened, const std::string& name);

  // Runs `act` with a connection in a transaction of the organisation. `act` may run twice.
  template <typename Act>
  auto Read(const Act& act) {
    return WithConnection(process->readers, [&](PostgresConnection& connection) {
      const PostgresReading reading(connection, setting);
      return act(connection);
    });
  }

  std::shared_ptr<PostgresProcess> process;
  std::string organisation;
  // Its transactions begin with it.
  std::string setting;
  ImageFiles images;
  BoxCache<RecallRow> recall_rows;
  BoxCache<MapRow> map_rows;
  BoxCache<std::string> overruled_ids;
  // Guards bounds_version and bounds.
  std::mutex bounds_mutex;
  uint64_t bounds_version = 0;
  RecallBounds bounds;

 private:
  void CheckThatImagesAreThere();
};

// A transaction of the organisation on a connection for writing.
class PostgresWrite : public PostgresTransaction {
 public:
  explicit PostgresWrite(PostgresState& state);
};

// Increases the version of sites. Writers of sites then take turns until they commit.
void StepSites(PostgresConnection& writer);
// The same for obstacles and sites.
void StepObstacles(PostgresConnection& writer);

}  // namespace freelsd
