#include "server/jobs/evaluation.h"

#include <algorithm>
#include <cmath>
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
#include "server/jobs/heap.h"
#include "server/jobs/out_of_date.h"
#include "server/jobs/staged_maps.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

struct NewSite {
  SiteRow row;
  // Empty if the site is rejected.
  std::optional<Landing> landing;
};

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

// When the newest of the block's photographs was taken.
int64_t PhotographedAt(const Snapshot& snapshot, const AdjustedBlock& block) {
  std::set<std::string> ids;
  for (const AdjustedView& view : block.views) ids.insert(view.frame_id);
  int64_t newest_us = 0;
  for (const View& view : snapshot.views) {
    if (ids.contains(view.frame_id)) newest_us = std::max(newest_us, view.timestamp_us);
  }
  return newest_us;
}

// Reads and decodes the stored image of a frame; empty if the file is missing.
ImageSource StoredImages(Service& service, const std::string& flight_id) {
  return [&service, flight_id](const std::string& frame_id) {
    const std::optional<FrameRow> frame = service.storage.frames.Find(flight_id, frame_id);
    if (!frame) return cv::Mat();
    const std::optional<std::string> bytes = service.storage.images.Read(frame->sha256);
    if (!bytes) return cv::Mat();
    return DecodeImage(*bytes, service.intake.image_limits);
  };
}

// The flight at the time of an evaluation. Its request has the datum of all its altitudes.
struct EvaluatedFlight {
  FlightRequest request;
  GeoPoint origin;
  FlightContext context;
  int min_num_observations = 0;
};

EvaluatedFlight FlightOf(const Service& service,
                         const std::string& flight_id,
                         const FlightSession& session,
                         const Snapshot& snapshot) {
  const std::optional<FlightRow> row = service.storage.flights.Find(flight_id);
  const std::string datum = row ? AltitudeDatumOf(*row) : "unknown";
  EvaluatedFlight flight{WithAltitudeDatum(session.request(), datum),
                         session.origin(),
                         session.Context(),
                         snapshot.min_num_observations};
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

Replan ReplanOf(const Site& site, const EvaluatedFlight& flight) {
  Replan replan;
  replan.flight = flight.request;
  replan.origin = flight.origin;
  replan.request.footprint = site.region.Footprint();
  replan.request.area_m2 = site.region.area_m2;
  replan.request.grade = site.region.grade;
  replan.request.num_observations = site.region.num_observations;
  replan.request.min_num_observations = flight.min_num_observations;
  if (site.wind) {
    replan.request.wind_in_world = site.wind->wind_in_world;
    replan.request.wind_spread_mps = site.wind->spread_mps;
  }
  return replan;
}

std::optional<RecallData> RecallOf(const Site& site,
                                   const FlightRequest& request,
                                   double altitude) {
  const Plan& plan = site.plan;
  if (plan.verdict == Verdict::kRejected || !plan.approach) return std::nullopt;
  if (!std::isfinite(altitude)) return std::nullopt;
  return RecallData{plan.verdict == Verdict::kLandable,
                    altitude,
                    request.altitude_datum.value_or("unknown"),
                    std::clamp(plan.score, 0.0, 1.0),
                    AircraftJson(request.aircraft).dump()};
}

// A site that only obstacles reject is stored with its plan without them. Whoever reads the site
// checks the plan against the obstacles of that time (AsObstructed), so that it is rejected for as
// long as they are there.
Site AsStored(Site site) {
  if (site.plan_without_obstacles) site.plan = *std::exchange(site.plan_without_obstacles, {});
  return site;
}

// Of a region, or of a square of the flight's world: stable while its ground is.
std::string NameWithin(const Site& site) {
  if (!site.square) return "-r" + std::to_string(site.region.id);
  return "-e" + std::to_string(site.square->east) + "n" + std::to_string(site.square->north);
}

// `map_id` is empty if nothing was reconstructed.
NewSite SiteOf(const Site& site,
               const Grid& grid,
               const std::string& map_id,
               const EvaluatedFlight& flight) {
  const FlightContext& context = flight.context;
  const FlightRequest& request = flight.request;
  NewSite made;
  made.row.id = context.flight_id + NameWithin(site);
  made.row.flight_id = context.flight_id;
  made.row.region_id = site.region.id;
  made.row.updated_at_us = NowUs();
  const GeoPoint touchdown = context.local_frame.GeoFromWorld(site.plan.touchdown_in_world);
  made.row.latitude_deg = touchdown.latitude_deg;
  made.row.longitude_deg = touchdown.longitude_deg;
  const std::string updated_at = Rfc3339(made.row.updated_at_us);
  made.row.seen_at_us = SeenAt(site.region.last_seen_us, made.row.updated_at_us);
  nlohmann::json feature = SiteFeature(made.row.id, site, request.aircraft, updated_at, context);
  feature["properties"]["last_seen_at"] = Rfc3339(made.row.seen_at_us);
  made.row.feature_json = feature.dump();
  if (site.plan.approach) made.row.approach_json = ApproachJson(site.plan, context).dump();
  made.row.replan_json = ReplanJson(ReplanOf(site, flight));
  made.row.map_datum = context.altitude_datum;
  made.row.recall = RecallOf(site, request, touchdown.altitude_m);
  if (made.row.recall) {
    const auto wind = site.wind ? std::optional(site.wind->wind_in_world) : std::nullopt;
    made.landing = LandingOf(touchdown, site.plan.approach->heading, wind);
  }
  if (!map_id.empty()) {
    made.row.map_id = map_id;
    const Grid around = grid.Part(
        grid.CellsAround(site.region.Footprint(), request.options.backend.max_surroundings_m));
    if (around.num_rows > 0) made.row.map_box = BoxOf(around, context.local_frame);
  }
  return made;
}

// Keeps only the best of several accepted sites at one place, and of several with one id: landable
// before unverified, then the better score.
void DropDuplicates(std::vector<NewSite>& sites) {
  const auto key = [](const NewSite& site) {
    const bool is_landable = site.row.recall && site.row.recall->is_landable;
    return std::tuple(!is_landable, site.row.recall ? -site.row.recall->score : 0.0, site.row.id);
  };
  std::sort(sites.begin(), sites.end(), [&key](const NewSite& a, const NewSite& b) {
    return key(a) < key(b);
  });
  std::vector<NewSite> kept;
  for (NewSite& site : sites) {
    const bool is_known = std::any_of(kept.begin(), kept.end(), [&](const auto& better) {
      if (better.row.id == site.row.id) return true;
      return better.landing && site.landing && IsSamePlace(*better.landing, *site.landing);
    });
    if (!is_known) kept.push_back(std::move(site));
  }
  sites = std::move(kept);
}

void StoreResult(Service& service,
                 const std::string& flight_id,
                 const std::vector<NewSite>& sites,
                 StagedMaps& maps,
                 EvaluationScope scope) {
  const std::lock_guard lock(service.sites_mutex);
  if (!service.storage.flights.Find(flight_id)) return;
  const std::vector<SiteRow> stored = service.storage.sites.List(flight_id, std::nullopt);
  EvaluationRows rows;
  for (const NewSite& site : sites) rows.sites.push_back(site.row);
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
  StoreEvaluation(service.storage, service.maps, std::move(rows));
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

std::vector<NewSite> SitesOf(const Evaluation& evaluation,
                             const std::string& map_id,
                             const EvaluatedFlight& flight) {
  std::vector<NewSite> sites;
  for (const Site& site : evaluation.sites) {
    sites.push_back(SiteOf(AsStored(site), evaluation.map.grid, map_id, flight));
  }
  return sites;
}

// Somebody may wait for the first site: it is in force before its map's picture is painted and
// before other groups are evaluated. The evaluation's own result replaces it.
void StoreFirstSites(Service& service,
                     const Evaluation& evaluation,
                     const StagedMaps::Source& source,
                     const EvaluatedFlight& flight) {
  if (evaluation.sites.empty()) return;
  StagedMaps maps(service, flight.context);
  std::vector<NewSite> sites =
      SitesOf(evaluation, maps.AddWithoutPicture(evaluation, source), flight);
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

}  // namespace

size_t EvaluateFlight(Service& service,
                      const std::string& flight_id,
                      FlightSession& session,
                      EvaluationScope scope,
                      const Progress& progress) {
  Snapshot snapshot = session.TakeSnapshot();
  const FlightRequest& request = session.request();
  const std::vector<RegionGroup> groups = GroupsToEvaluate(snapshot, scope, request.options);
  const EvaluatedFlight flight = FlightOf(service, flight_id, session, snapshot);
  snapshot.obstacles = ObstaclesOf(service, flight, snapshot);
  StagedMaps maps(service, flight.context);
  std::vector<NewSite> sites;
  std::vector<std::string> warnings;
  const ImageSource images = StoredImages(service, flight_id);
  const bool is_first = service.storage.maps.ListOf(flight_id).empty();
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
        flight.request, flight.origin, images, PhotographedAt(snapshot, evaluation.block)};
    if (is_first) StoreFirstSites(service, evaluation, source, flight);
    const std::string map_id = maps.Add(evaluation, source, Within(of_group, kSitesDone, 1.0));
    for (NewSite& site : SitesOf(evaluation, map_id, flight)) sites.push_back(std::move(site));
    session.AddReports(evaluation.reports);
    AddNew(evaluation.warnings, warnings);
  }
  if (sites.empty()) warnings = NoSiteReason(snapshot);
  DropDuplicates(sites);
  StoreResult(service, flight_id, sites, maps, scope);
  service.alternates.Wake(flight_id);
  service.alternates.WakeAll();
  session.Store(service.storage);
  service.storage.flights.Change(flight_id, [&](FlightRow& row) {
    row.warnings_json = ReplaceWarnings(row.warnings_json, "evaluation", warnings);
  });
  return sites.size();
}

}  // namespace freelsd
