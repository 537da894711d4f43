// The state that all stores share: pools of connections, the image files, and caches for recall.
#pragma once

#include <atomic>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "storage/database.h"
#include "storage/folder_lock.h"
#include "storage/image_files.h"
#include "storage/postgres/ownership.h"
#include "storage/postgres/pool.h"
#include "storage/postgres/registration.h"
#include "storage/storage.h"

namespace freelsd {

// What this process has of the database. Thread-safe. Readers and writers have pools of their own,
// so that readers never wait for writers.
struct PostgresState final : public StoreAccess {
  // Opens the database, and creates its schema in an empty one.
  explicit PostgresState(const StorageOptions& given);

  const Dialect& dialect() const override { return own_dialect; }
  bool HasImage(const std::string& sha256) const override { return images.Has(sha256); }
  uint64_t SitesVersion() override { return VersionOf("sites"); }
  uint64_t ObstaclesVersion() override { return VersionOf("obstacles"); }
  std::unique_ptr<Turn> TakeTurn() override;
  int64_t NextMapNumber(const std::string& flight_id) override;

  // Runs `act` with a connection for reading. `act` may run twice.
  template <typename Act>
  auto Read(const Act& act) {
    return WithConnection(readers, act);
  }
  // Throws StorageError after MarkDamaged.
  ConnectionPool& Writers();
  void MarkDamaged(const std::string& why);
  // The version of 'sites' or 'obstacles'.
  uint64_t VersionOf(const std::string& name);

  StorageOptions options;
  Dialect own_dialect;
  FolderLock lock;
  ConnectionPool readers;
  ConnectionPool writers;
  // For what may wait neither for readers nor for writers: ownership and registration.
  ConnectionPool owner_pool;
  // Of one connection, for `listener`: it hears when others tell something. Empty until it is
  // needed, and after the connection broke. Only the thread that calls ListTold uses it.
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
  ImageFiles images;

 private:
  void ReadWith(Reading from, const std::function<void(Database&)>& act) override;
  void WriteWith(Writing what, Teller teller, const std::function<void(Writer&)>& act) override;
  // Takes the database, once it has its schema. Returns the folder of the images, in which nothing
  // has changed if this throws.
  std::filesystem::path Open();
  void CheckThatImagesAreThere();
};

// While it lives, its thread is told these versions, and does not ask the database again.
class HeldVersions : public VersionHold {
 public:
  explicit HeldVersions(PostgresState& state);
  ~HeldVersions() override;
  // Nothing if this thread holds no versions of the state.
  static std::optional<uint64_t> Find(const PostgresState& state, const std::string& name);

 private:
  const PostgresState& state_;
  const HeldVersions* before_;
  std::map<std::string, uint64_t> versions_;
};

// A transaction on one of the state's connections for writing.
class PostgresWrite : public PostgresTransaction {
 public:
  explicit PostgresWrite(PostgresState& state);
};

}  // namespace freelsd
