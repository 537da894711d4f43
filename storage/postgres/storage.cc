#include "storage/backend.h"
#include "storage/postgres/dialect.h"
#include "storage/postgres/site_queries.h"
#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

class PostgresBackend final : public StorageBackend {
 public:
  explicit PostgresBackend(const StorageOptions& options) : state_(options) {
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
  DatabaseKind Kind() const override { return DatabaseKind::kPostgres; }
  std::filesystem::path SpoolFolder() const override { return state_.options.folder / "spool"; }
  std::optional<std::string> WhyNotWritable() override;
  void MarkDamaged(const std::string& why) override { state_.MarkDamaged(why); }
  NoticeBoard& notices() override { return state_.notices; }
  std::unique_ptr<VersionHold> HoldVersions() override {
    return std::make_unique<HeldVersions>(state_);
  }
  std::vector<PoolState> Pools() override {
    return {state_.readers.State("readers"), state_.writers.State("writers")};
  }

 private:
  PostgresState state_;
  SqlFlightStore flights_{state_};
  SqlFrameStore frames_{state_};
  PostgresImageStore images_{state_};
  SqlJobStore jobs_{state_};
  SqlTelemetryStore telemetry_{state_, kPostgresTelemetry};
  SqlSiteStore sites_{state_, kPostgresSites};
  SqlMapStore maps_{state_, kPostgresMaps};
  SqlObstacleStore obstacles_{state_};
  PostgresClaimStore claims_{state_};
  SqlChangeStore changes_{state_};
};

std::optional<std::string> PostgresBackend::WhyNotWritable() {
  for (const auto& folder : {state_.options.images_folder, state_.options.folder}) {
    if (auto reason = WhyDiskIsFull(folder)) return reason;
  }
  try {
    PostgresWrite writer(state_);
    // Refused on a server that is read-only.
    writer->Execute("LOCK TABLE versions IN ROW EXCLUSIVE MODE");
  } catch (const StorageError& failure) {
    return failure.what();
  }
  return std::nullopt;
}

}  // namespace

std::unique_ptr<StorageBackend> OpenPostgres(const StorageOptions& options) {
  return std::make_unique<PostgresBackend>(options);
}

}  // namespace freelsd
