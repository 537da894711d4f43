#include "server/jobs/evaluation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/export/layers/layers.h"
#include "api/import/images/images.h"
#include "api/stored/stored.h"
#include "server/http/http.h"
#include "server/intake/intake.h"
#include "server/jobs/evaluated_area.h"
#include "server/jobs/evidence/evidence.h"
#include "server/jobs/heap.h"
#include "server/jobs/out_of_date.h"
#include "server/jobs/sites/sites.h"
#include "server/jobs/staged_maps.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

std::vector<Candidate> RegionsToEvaluate(const Snapshot& snapshot,
                                         EvaluationScope scope,
                                         const BackendOptions& options) {
  std::vector<Candidate> regions;
  const size_t max_num_regions = scope == EvaluationScope::kEveryGraded
                                     ? snapshot.regions.size()
                                     : static_cast<size_t>(options.num_backend_candidates);
  for (const Candidate& candidate : snapshot.regions) {  // best first
    const bool is_graded = candidate.region.grade > 0.0;
    if (is_graded && regions.size() < max_num_regions) regions.push_back(candidate);
  }
  return regions;
}

std::vector<RegionGroup> GroupsToEvaluate(const Snapshot& snapshot,
                                          EvaluationScope scope,
                                          const PipelineOptions& options) {
  const std::vector<Candidate> regions = RegionsToEvaluate(snapshot, scope, options.backend);
  if (scope == EvaluationScope::kEveryGraded) return GroupRegions(snapshot, regions, options);
  if (regions.empty()) return {};
  return {{regions, AreaAround(regions, options.backend)}};
}

std::string DatumOf(const Service& service, const std::string& flight_id) {
  const std::optional<FlightRow> row = service.storage.flights.Find(flight_id);
  return row ? AltitudeDatumOf(*row) : "unknown";
}

EvaluatedFlight FlightOf(const Service& service,
                         const std::string& flight_id,
                         FlightSession& session,
                         const Snapshot& snapshot) {
  const std::string datum = DatumOf(service, flight_id);
  EvaluatedFlight flight{WithAltitudeDatum(session.request(), datum),
                         session.origin(),
                         session.Context(),
                         snapshot.min_num_observations,
                         session.TimesOfFrames()};
  flight.context.altitude_datum = datum;
  return flight;
}

// Those near the flight's regions.
std::vector<HardObstacle> ObstaclesOf(Service& service,
                                      const EvaluatedFlight& flight,
                                      const Snapshot& snapshot) {
  constexpr double kSurroundingsM = 2000.0;
  double reach_m = 0.0;
  for (const Candidate& candidate : snapshot.regions) {
    for (const Eigen::Vector2d& corner : candidate.region.Footprint()) {
      reach_m = std::max(reach_m, corner.norm());
    }
  }
  const std::string& datum = flight.context.altitude_datum;
  return InWorld(
      service.maps.ObstaclesNear(service.storage,
                                 BoxAroundPlace(flight.origin, reach_m + kSurroundingsM)),
      flight.context.local_frame,
      {datum, flight.origin.latitude_deg, flight.origin.longitude_deg, flight.context.flight_id});
}

void StoreResult(Service& service,
                 const std::string& flight_id,
                 const std::vector<NewSite>& sites,
                 StagedMaps& maps,
                 EvaluationScope scope) {
  const std::unique_ptr<SiteTurn> turn = service.storage.sites.TakeTurn();
  const std::optional<FlightRow> flight = service.storage.flights.Find(flight_id);
  if (!flight) return;
  const FlightMemory memory = ParseStoredFlight(flight->request_json).memory;
  const std::vector<SiteRow> stored = service.storage.sites.List(flight_id, std::nullopt);
  EvaluationRows rows;
  for (const NewSite& site : sites) rows.sites.push_back(AsRemembered(site.row, memory));
  rows.forgotten_sites = OutOfDateSites(stored, rows.sites, maps.rows(), scope);
  std::set<std::string> gone(rows.forgotten_sites.begin(), rows.forgotten_sites.end());
  for (const SiteRow& site : rows.sites) gone.insert(site.id);
  std::set<std::string> needed;
  for (const SiteRow& site : stored) {
    if (!gone.contains(site.id)) needed.insert(site.map_id);
  }
  for (const FlightMapRow& map : maps.rows()) rows.new_maps.push_back(map.id);
  rows.forgotten_maps =
      OutOfDateMaps(service.storage.maps.ListOf(flight_id), maps.rows(), needed, scope);
  StoreEvaluation(service.storage, service.maps, *turn, std::move(rows));
  for (const NewSite& site : sites) {
    service.events.Publish(
        "site", flight_id, nlohmann::json{{"id", site.row.id}, {"flight_id", flight_id}}.dump());
  }
  for (const FlightMapRow& map : maps.rows()) {
    service.events.Publish(
        "map",
        flight_id,
        nlohmann::json{{"flight_id", flight_id}, {"updated_at", Rfc3339(map.updated_at_us)}}
            .dump());
  }
  maps.Take();
}

// Somebody may wait for the first site: it is in force before its map's picture is painted and
// before other groups are evaluated. The evaluation's own result replaces it.
void StoreFirstSites(Service& service,
                     const Evaluation& evaluation,
                     const StagedMaps::Source& source,
                     const EvaluatedFlight& flight,
                     const std::string& inputs_digest) {
  if (evaluation.sites.empty()) return;
  StagedMaps maps(service, flight.context);
  const std::string map_id = maps.AddWithoutPicture(evaluation, source);
  std::vector<NewSite> sites =
      SitesOf(evaluation, {map_id, maps.DigestOf(map_id), inputs_digest}, flight);
  DropDuplicates(sites);
  StoreResult(service, flight.context.flight_id, sites, maps, EvaluationScope::kBest);
  service.alternates.Wake(flight.context.flight_id);
  service.alternates.WakeAll();
}

// The warning of a flight without any site.
std::vector<std::string> NoSiteReason(const Snapshot& snapshot) {
  if (snapshot.regions.empty()) {
    return {"no sites: no smooth ground was found in any photograph"};
  }
  const auto seen_most = std::max_element(
      snapshot.regions.begin(), snapshot.regions.end(), [](const Candidate& a, const Candidate& b) {
        return a.region.num_observations < b.region.num_observations;
      });
  int num_grass_at_most = 0;
  for (const auto& [region, wind] : snapshot.regions) {
    num_grass_at_most = std::max(num_grass_at_most, region.num_grass_observations);
  }
  return {"no sites: none of the " + std::to_string(snapshot.regions.size()) +
          " regions has a grade above 0 (seen at most " +
          std::to_string(seen_most->region.num_observations) + " times, " +
          std::to_string(snapshot.min_num_observations) + " are needed; seen as grass at most " +
          std::to_string(num_grass_at_most) + " times)"};
}

// Share of a group's evaluation after which only its picture is left.
constexpr double kSitesDone = 0.75;

// Progress of a part, from one share of the whole to another.
Progress Within(const Progress& progress, double from, double to) {
  if (!progress) return progress;
  return [progress, from, to](double done_ratio, const std::string& stage) {
    return progress(from + (to - from) * done_ratio, stage);
  };
}

// Each stage leaves many gaps in the heap that the next, whose rasters are larger, cannot use.
Progress ReturningMemory(const Progress& progress) {
  return [progress, last = std::string()](double done_ratio, const std::string& stage) mutable {
    if (std::exchange(last, stage) != stage) ReturnFreedMemory();
    return !progress || progress(done_ratio, stage);
  };
}

// Progress of one of several groups of equal size.
Progress ShareOf(const Progress& progress, size_t index, size_t num_groups) {
  const auto count = static_cast<double>(num_groups);
  return Within(
      progress, static_cast<double>(index) / count, static_cast<double>(index + 1) / count);
}

void AddNew(const std::vector<std::string>& more, std::vector<std::string>& warnings) {
  for (const std::string& warning : more) {
    if (std::find(warnings.begin(), warnings.end(), warning) == warnings.end()) {
      warnings.push_back(warning);
    }
  }
}

// An evaluation's sites, on staged maps.
struct Evaluated {
  std::vector<NewSite> sites;
  std::vector<std::string> warnings;
  int64_t through_sequence = 0;
};

struct EvaluationTask {
  Service& service;
  const std::string& flight_id;
  FlightSession& session;
  EvaluationScope scope;
  // False: a replay, which stores nothing and paints no picture.
  bool is_stored = true;
};

EvaluationInputs InputsOf(const EvaluationTask& task,
                          const EvaluatedFlight& flight,
                          int64_t through_sequence) {
  return {
      task.flight_id, through_sequence, flight.request, flight.origin, task.session.model_digest()};
}

Evaluated Evaluate(const EvaluationTask& task, StagedMaps& maps, const Progress& progress) {
  Service& service = task.service;
  auto [snapshot, through_sequence] = task.session.TakeSnapshot();
  const FlightRequest& request = task.session.request();
  const std::vector<RegionGroup> groups = GroupsToEvaluate(snapshot, task.scope, request.options);
  const EvaluatedFlight flight = FlightOf(service, task.flight_id, task.session, snapshot);
  const std::string inputs =
      InputsDigest(service.storage, InputsOf(task, flight, through_sequence));
  snapshot.obstacles = ObstaclesOf(service, flight, snapshot);
  Evaluated evaluated;
  evaluated.through_sequence = through_sequence;
  const ImageSource images = StoredImages(service.intake, task.flight_id);
  const bool is_first = task.is_stored && service.storage.maps.ListOf(task.flight_id).empty();
  for (size_t i = 0; i < groups.size(); ++i) {
    const Progress of_group = ReturningMemory(ShareOf(progress, i, groups.size()));
    service.progress.SetArea(AreaJson(groups[i].area, flight.context.local_frame));
    const Evaluation evaluation = EvaluateSites(snapshot,
                                                groups[i],
                                                images,
                                                request.aircraft,
                                                request.options,
                                                Within(of_group, 0.0, kSitesDone));
    const StagedMaps::Source source{
        flight.request, flight.origin, images, task.session.model_digest(), flight.times};
    if (is_first) StoreFirstSites(service, evaluation, source, flight, inputs);
    const std::string map_id = task.is_stored
                                   ? maps.Add(evaluation, source, Within(of_group, kSitesDone, 1.0))
                                   : maps.AddWithoutPicture(evaluation, source);
    for (NewSite& site : SitesOf(evaluation, {map_id, maps.DigestOf(map_id), inputs}, flight)) {
      evaluated.sites.push_back(std::move(site));
    }
    task.session.AddReports(evaluation.reports);
    AddNew(evaluation.warnings, evaluated.warnings);
  }
  if (evaluated.sites.empty()) evaluated.warnings = NoSiteReason(snapshot);
  DropDuplicates(evaluated.sites);
  return evaluated;
}

}  // namespace

EvaluationCount EvaluateFlight(Service& service,
                               const std::string& flight_id,
                               FlightSession& session,
                               EvaluationScope scope,
                               const Progress& progress) {
  FlightContext context = session.Context();
  context.altitude_datum = DatumOf(service, flight_id);
  StagedMaps maps(service, context);
  const Evaluated evaluated = Evaluate({service, flight_id, session, scope}, maps, progress);
  StoreResult(service, flight_id, evaluated.sites, maps, scope);
  service.alternates.Wake(flight_id);
  service.alternates.WakeAll();
  session.Store(service.storage);
  service.storage.flights.Change(flight_id, [&](FlightRow& row) {
    row.warnings_json = ReplaceWarnings(row.warnings_json, "evaluation", evaluated.warnings);
  });
  return {evaluated.sites.size(), evaluated.through_sequence};
}

std::map<std::string, std::string> EvidenceDigests(Service& service,
                                                   const std::string& flight_id,
                                                   FlightSession& session,
                                                   const Progress& progress) {
  FlightContext context = session.Context();
  context.altitude_datum = DatumOf(service, flight_id);
  StagedMaps maps(service, context);
  const EvaluationTask task{service, flight_id, session, EvaluationScope::kEveryGraded, false};
  std::map<std::string, std::string> digests;
  for (const NewSite& site : Evaluate(task, maps, progress).sites) {
    digests[site.row.id] = site.digest;
  }
  return digests;
}

}  // namespace freelsd
