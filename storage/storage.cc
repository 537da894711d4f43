#include "storage/storage.h"

#include "storage/backend.h"

namespace freelsd {

std::optional<std::string> WhyDiskIsFull(const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error) return error.message();
  if (space.available < kMinFreeBytes) return "less than 256 MiB are free on the disk";
  return std::nullopt;
}

void EmptyFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::remove_all(folder, error);
  std::filesystem::create_directories(folder, error);
  if (error) throw StorageError("create folder " + folder.string(), error.message());
}

Storage::Storage(const std::filesystem::path& folder)
    : Storage([&folder] {
        StorageOptions options;
        options.folder = folder;
        return options;
      }()) {}

Storage::Storage(const StorageOptions& options)
    : Storage(options.database_url.empty() ? OpenSqlite(options) : OpenPostgres(options)) {}

Storage::Storage(std::unique_ptr<StorageBackend> backend)
    : backend_(std::move(backend)),
      flights(backend_->stores().flights),
      frames(backend_->stores().frames),
      images(backend_->stores().images),
      jobs(backend_->stores().jobs),
      telemetry(backend_->stores().telemetry),
      sites(backend_->stores().sites),
      maps(backend_->stores().maps),
      obstacles(backend_->stores().obstacles),
      claims(backend_->stores().claims),
      changes(backend_->stores().changes) {}

Storage::~Storage() = default;

DatabaseKind Storage::Kind() const { return backend_->Kind(); }

std::filesystem::path Storage::SpoolFolder() const { return backend_->SpoolFolder(); }

std::unique_ptr<VersionHold> Storage::HoldVersions() const { return backend_->HoldVersions(); }

std::vector<PoolState> Storage::Pools() const { return backend_->Pools(); }

std::optional<std::string> Storage::WhyNotWritable() const { return backend_->WhyNotWritable(); }

void Storage::MarkDamaged(const std::string& why) const { backend_->MarkDamaged(why); }

std::vector<Notice> Storage::ListNotices() const { return backend_->notices().List(); }

std::vector<std::string> Storage::Notices() const {
  std::vector<std::string> texts;
  for (Notice& notice : ListNotices()) {
    if (!notice.acknowledged_at_us) texts.push_back(std::move(notice.text));
  }
  return texts;
}

bool Storage::AcknowledgeNotice(const std::string& id) const {
  return backend_->notices().Acknowledge(id);
}

}  // namespace freelsd
