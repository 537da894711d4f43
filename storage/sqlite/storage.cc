#include "storage/backend.h"
#include "storage/sqlite/dialect.h"
#include "storage/sqlite/site_queries.h"
#include "storage/sqlite/state.h"
#include "storage/sqlite/stores.h"

namespace freelsd {
namespace {

class SqliteBackend final : public StorageBackend {
 public:
  explicit SqliteBackend(const StorageOptions& options)
      : state_(OpenState(options.folder, options.log_notice)) {
    EmptyFolder(SpoolFolder());
  }

  Stores stores() override {
    return {flights_,
            frames_,
            images_,
            jobs_,
            telemetry_,
            sites_,
            maps_,
            obstacles_,
            claims_,
            changes_};
  }
  DatabaseKind Kind() const override { return DatabaseKind::kSqlite; }
  std::filesystem::path SpoolFolder() const override { return state_->folder / "spool"; }
  std::optional<std::string> WhyNotWritable() override;
  void MarkDamaged(const std::string& why) override { state_->MarkDamaged(why); }
  NoticeBoard& notices() override { return state_->notices; }

 private:
  std::unique_ptr<StorageState> state_;
  SqlFlightStore flights_{*state_};
  SqlFrameStore frames_{*state_};
  SqliteImageStore images_{*state_};
  SqlJobStore jobs_{*state_};
  SqlTelemetryStore telemetry_{*state_, kSqliteTelemetry};
  SqlSiteStore sites_{*state_, kSqliteSites};
  SqlMapStore maps_{*state_, kSqliteMaps};
  SqlObstacleStore obstacles_{*state_};
  SqliteClaimStore claims_;
  SqlChangeStore changes_{*state_};
};

std::optional<std::string> SqliteBackend::WhyNotWritable() {
  if (state_->is_damaged) return "the database is damaged";
  if (auto reason = WhyDiskIsFull(state_->folder)) return reason;
  try {
    const auto lock = state_->LockForWriting();
    const Transaction transaction(state_->writer);
  } catch (const StorageError& failure) {
    return failure.what();
  }
  return std::nullopt;
}

}  // namespace

std::unique_ptr<StorageBackend> OpenSqlite(const StorageOptions& options) {
  return std::make_unique<SqliteBackend>(options);
}

}  // namespace freelsd
