#include "storage/backend.h"
#include "storage/postgres/organisations/organisations.h"
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
  NoticeBoard& notices() override { return state_.process->notices; }
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

// Marks the organisation's next sites, after the one of that id, that lie on a map of `sharing`:
// they were never checked on these. All of them where no index finds maps. Returns the last id; ""
// if there was none left.
std::string MarkNextUnchecked(PostgresConnection& writer,
                              const std::string& name,
                              const std::string& after_id,
                              const std::string& sharing) {
  writer.Run("SELECT set_config('freelsd.organisation', $1, true)", name);
  const PostgresRows last = writer.Run(
      "WITH next AS (SELECT id FROM sites WHERE organisation = $1 AND is_recallable AND id > $2 "
      "ORDER BY id LIMIT 1000), "
      "marked AS (UPDATE sites SET is_checked = false WHERE id IN (SELECT id FROM next) AND ($4 OR "
      "EXISTS (SELECT 1 FROM site_areas AS own JOIN map_areas AS others ON own.area && others.area "
      "WHERE own.organisation = $1 AND own.site_id = sites.id AND others.organisation = $3))) "
      "SELECT coalesce(max(id), '') FROM next",
      name,
      after_id,
      sharing,
      !FindsBoxesByIndex(writer));
  return last[0].Text(0);
}

// Other organisations' sites on the ground that this one has begun to share. In many commits: there
// may be a million. A start that was interrupted goes on with it.
void MarkUnchecked(PostgresState& state) {
  std::vector<std::string> others;
  {
    PostgresWrite writer(state);
    if (writer
            ->Run("SELECT 1 FROM organisations WHERE name = $1 AND has_unchecked_ground",
                  state.organisation)
            .empty()) {
      return;
    }
    ServeAllOrganisations(*writer);
    others = writer
                 ->Run("SELECT name FROM organisations WHERE name <> $1 ORDER BY name",
                       state.organisation)
                 .Texts();
  }
  for (const std::string& name : others) {
    std::string last;
    do {
      PostgresWrite writer(state);
      last = MarkNextUnchecked(*writer, name, last, state.organisation);
      writer.Commit();
    } while (!last.empty());
  }
  PostgresWrite writer(state);
  writer->Run("UPDATE organisations SET has_unchecked_ground = false WHERE name = $1",
              state.organisation);
  writer.Commit();
}

void PostgresBackend::ShareSites(bool is_shared) {
  {
    PostgresWrite writer(state_);
    const bool has_changed = writer
                                 ->Run(
                                     "UPDATE organisations SET shares_sites = $2, "
                                     "has_unchecked_ground = $2 "
                                     "WHERE name = $1 AND shares_sites <> $2",
                                     state_.organisation,
                                     is_shared)
                                 .NumChanges() > 0;
    // What others have read of it, or not, is out of date.
    if (has_changed) StepObstacles(*writer);
    writer.Commit();
  }
  if (is_shared) MarkUnchecked(state_);
}

}  // namespace

std::unique_ptr<StorageBackend> OpenPostgres(const StorageOptions& options) {
  auto process = std::make_shared<PostgresProcess>(options);
  EmptyFolder(options.folder / "spool");
  return std::make_unique<PostgresBackend>(std::move(process), kDefaultOrganisation);
}

}  // namespace freelsd
