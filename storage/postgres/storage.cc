#include "storage/backend.h"
#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

class PostgresBackend final : public StorageBackend {
 public:
  PostgresBackend(std::shared_ptr<PostgresProcess> process, const std::string& organisation)
      : state_(std::move(process), organisation) {}

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
            quotas_,
            changes_};
  }
  DatabaseKind Kind() const override { return DatabaseKind::kPostgres; }
  std::filesystem::path SpoolFolder() const override {
    return state_.process->options.folder / "spool";
  }
  std::optional<std::string> WhyNotWritable() override;
  std::unique_ptr<StorageBackend> ForOrganisation(const std::string& name) override {
    return std::make_unique<PostgresBackend>(state_.process, name);
  }
  void ShareSites(bool is_shared) override;
  void MarkDamaged(const std::string& why) override { state_.process->MarkDamaged(why); }
  std::vector<std::string> Notices() override {
    const std::lock_guard lock(state_.process->notices_mutex);
    return state_.process->notices;
  }
  std::unique_ptr<VersionHold> HoldVersions() override {
    return std::make_unique<HeldVersions>(*state_.process);
  }
  std::vector<PoolState> Pools() override {
    return {state_.process->readers.State("readers"), state_.process->writers.State("writers")};
  }

 private:
  PostgresState state_;
  PostgresFlightStore flights_{state_};
  PostgresFrameStore frames_{state_};
  PostgresImageStore images_{state_};
  PostgresJobStore jobs_{state_};
  PostgresTelemetryStore telemetry_{state_};
  PostgresSiteStore sites_{state_};
  PostgresMapStore maps_{state_};
  PostgresObstacleStore obstacles_{state_};
  PostgresClaimStore claims_{state_};
  PostgresQuotaStore quotas_{state_};
  PostgresChangeStore changes_{state_};
};

std::optional<std::string> PostgresBackend::WhyNotWritable() {
  for (const auto& folder :
       {state_.process->options.images_folder, state_.process->options.folder}) {
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

// Within the transaction that shares them: others' sites on its maps were never checked on these.
void CheckSitesAgain(PostgresConnection& writer, const std::string& sharing) {
  ServeAllOrganisations(writer);
  const std::vector<std::string> names =
      writer.Run("SELECT name FROM organisations WHERE name <> $1 ORDER BY name", sharing).Texts();
  writer.Execute("SELECT set_config('freelsd.all_organisations', 'off', true)");
  for (const std::string& name : names) {
    writer.Run("SELECT set_config('freelsd.organisation', $1, true)", name);
    writer.Run(
        "UPDATE sites SET is_checked = false WHERE organisation = $1 AND is_recallable AND EXISTS "
        "(SELECT 1 FROM site_areas AS own JOIN map_areas AS others ON own.area && others.area "
        "WHERE own.organisation = $1 AND own.site_id = sites.id AND others.organisation = $2)",
        name,
        sharing);
  }
}

void PostgresBackend::ShareSites(bool is_shared) {
  PostgresWrite writer(state_);
  const bool has_changed =
      writer
          ->Run("UPDATE organisations SET shares_sites = $2 WHERE name = $1 AND shares_sites <> $2",
                state_.organisation,
                is_shared)
          .NumChanges() > 0;
  // What others have read of it, or not, is out of date.
  if (has_changed) StepObstacles(*writer);
  if (has_changed && is_shared) CheckSitesAgain(*writer, state_.organisation);
  writer.Commit();
}

}  // namespace

std::unique_ptr<StorageBackend> OpenPostgres(const StorageOptions& options) {
  auto process = std::make_shared<PostgresProcess>(options);
  EmptyFolder(options.folder / "spool");
  return std::make_unique<PostgresBackend>(std::move(process), kDefaultOrganisation);
}

}  // namespace freelsd
