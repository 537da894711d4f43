// What a database must give to be a Storage.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "storage/storage.h"

namespace freelsd {

struct Stores {
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
};

// Its methods do what those of Storage with the same names do.
class StorageBackend {
 public:
  virtual ~StorageBackend() = default;
  StorageBackend(const StorageBackend&) = delete;
  StorageBackend& operator=(const StorageBackend&) = delete;

  virtual Stores stores() = 0;
  virtual DatabaseKind Kind() const = 0;
  virtual std::filesystem::path SpoolFolder() const = 0;
  virtual std::optional<std::string> WhyNotWritable() = 0;
  virtual void MarkDamaged(const std::string& why) = 0;
  virtual NoticeBoard& notices() = 0;
  virtual std::vector<PoolState> Pools() { return {}; }
  virtual std::unique_ptr<VersionHold> HoldVersions() { return nullptr; }

 protected:
  StorageBackend() = default;
};

std::unique_ptr<StorageBackend> OpenSqlite(const StorageOptions& options);
std::unique_ptr<StorageBackend> OpenPostgres(const StorageOptions& options);

// Bytes that a disk must have free so that results still fit; with less, nothing is accepted.
constexpr uint64_t kMinFreeBytes = uint64_t{256} << 20;
// Why the folder's disk takes no more data; nothing if it does.
std::optional<std::string> WhyDiskIsFull(const std::filesystem::path& folder);
// Empties the folder, or creates it.
void EmptyFolder(const std::filesystem::path& folder);

}  // namespace freelsd
