#include "server/work/evaluation.h"

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
#include "server/recall/recall.h"
#include "server/work/evaluated_area.h"

namespace freelsd {
namespace {

// An earlier timestamp comes from a camera whose clock was never set.
constexpr int64_t kEarliestCaptureUs = 1262304000000000;  // 2010

struct NewSite {
  SiteRow row;
  std::string map_blob;
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

// The box of the stored map, from its corners.
BoundingBox BoxOf(const Grid& grid, const LocalFrame& local_frame) {
  const Eigen::Vector2d size(grid.num_cols * grid.cell_size_m, -grid.num_rows * grid.cell_size_m);
  BoundingBox box{180.0, 90.0, -180.0, -90.0};
  for (const double x : {0.0, 1.0}) {
    for (const double y : {0.0, 1.0}) {
      const Eigen::Vector2d corner =
          grid.north_west_in_world + Eigen::Vector2d(x * size.x(), y * size.y());
      const GeoPoint place = local_frame.GeoFromWorld({corner.x(), corner.y(), 0.0});
      box.west_deg = std::min(box.west_deg, place.longitude_deg);
      box.east_deg = std::max(box.east_deg, place.longitude_deg);
      box.south_deg = std::min(box.south_deg, place.latitude_deg);
      box.north_deg = std::max(box.north_deg, place.latitude_deg);
    }
  }
  return box;
}

// When the region was last photographed: the photographs' own time if it is plausible, because an
// old flight may be uploaded today; else now, the latest possible time.
int64_t SeenAt(const Region& region, int64_t now_us) {
  const bool is_plausible =
      region.last_seen_us >= kEarliestCaptureUs && region.last_seen_us <= now_us;
  return is_plausible ? region.last_seen_us : now_us;
}

// A site that only obstacles reject is stored with its plan without them. Whoever reads the site
// checks the plan against the obstacles of that time (AsObstructed), so that it is rejected for as
// long as they are there.
Site AsStored(Site site) {
  if (site.plan_without_obstacles) site.plan = *std::exchange(site.plan_without_obstacles, {});
  return site;
}

NewSite SiteOf(const Site& site, const Evaluation& evaluation, const EvaluatedFlight& flight) {
  const FlightContext& context = flight.context;
  const FlightRequest& request = flight.request;
  NewSite made;
  made.row.id = context.flight_id + "-r" + std::to_string(site.region.id);
  if (site.field_number > 1) made.row.id += "-f" + std::to_string(site.field_number);
  made.row.flight_id = context.flight_id;
  made.row.region_id = site.region.id;
  made.row.updated_at_us = NowUs();
  const GeoPoint touchdown = context.local_frame.GeoFromWorld(site.plan.touchdown_in_world);
  made.row.latitude_deg = touchdown.latitude_deg;
  made.row.longitude_deg = touchdown.longitude_deg;
  const std::string updated_at = Rfc3339(made.row.updated_at_us);
  made.row.seen_at_us = SeenAt(site.region, made.row.updated_at_us);
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
  if (evaluation.map.grid.num_rows > 0) {
    const SiteMap cropped = CropAround(evaluation.map,
                                       evaluation.hazards,
                                       site.region.Footprint(),
                                       request.options.backend.max_surroundings_m);
    made.map_blob = SerializeSiteMap(cropped);
    if (cropped.map.grid.num_rows > 0) {
      made.row.map_box = BoxOf(cropped.map.grid, context.local_frame);
    }
  }
  return made;
}

// Keeps only the best of several accepted sites at one place: landable before unverified, then the
// better score.
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
    const bool is_known =
        site.landing && std::any_of(kept.begin(), kept.end(), [&](const auto& better) {
          return better.landing && IsSamePlace(*better.landing, *site.landing);
        });
    if (!is_known) kept.push_back(std::move(site));
  }
  sites = std::move(kept);
}

// True if the ground of the site was evaluated again for one of the new sites.
bool IsReplaced(const SiteRow& site, const std::vector<Replan>& replans) {
  return std::any_of(replans.begin(), replans.end(), [&site](const Replan& replan) {
    const GeoPoint place{site.latitude_deg, site.longitude_deg, replan.origin.altitude_m};
    const Eigen::Vector3d in_world = LocalFrame(replan.origin).WorldFromGeo(place);
    return Contains(replan.request.footprint, in_world.head<2>());
  });
}

void StoreSites(Service& service,
                const std::string& flight_id,
                std::vector<NewSite> sites,
                EvaluationScope scope) {
  const std::lock_guard lock(service.sites_mutex);
  if (!service.storage.flights.Find(flight_id)) return;
  std::set<std::string> ids;
  std::set<int64_t> region_ids;
  std::vector<Replan> replans;
  for (NewSite& site : sites) {
    replans.push_back(ParseReplan(site.row.replan_json));
    StoreSite(service.storage, service.maps, site.row, site.map_blob);
    ids.insert(site.row.id);
    region_ids.insert(site.row.region_id);
    service.events.Publish(
        "site", flight_id, nlohmann::json{{"id", site.row.id}, {"flight_id", flight_id}}.dump());
  }
  for (const SiteRow& site : service.storage.sites.List(flight_id, std::nullopt)) {
    const bool is_out_of_date =
        scope == EvaluationScope::kEveryGraded || region_ids.contains(site.region_id);
    // An accepted site stays until its ground is evaluated again, even if its region is no longer
    // among the best.
    const bool is_accepted_elsewhere =
        site.recall && !region_ids.contains(site.region_id) && !IsReplaced(site, replans);
    if (is_out_of_date && !is_accepted_elsewhere && !ids.contains(site.id)) {
      ForgetSite(service.storage, service.maps, site.id);
    }
  }
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

// Progress of one of several groups of equal size, scaled to progress of the whole.
Progress ShareOf(const Progress& progress, size_t index, size_t num_groups) {
  if (!progress) return progress;
  return [&progress, index, num_groups](double done_ratio, const std::string& stage) {
    return progress((static_cast<double>(index) + done_ratio) / static_cast<double>(num_groups),
                    stage);
  };
}

}  // namespace

size_t EvaluateFlight(Service& service,
                      const std::string& flight_id,
                      FlightSession& session,
                      EvaluationScope scope,
                      const Progress& progress) {
  Snapshot snapshot = session.TakeSnapshot();
  const FlightRequest& request = session.request();
  const std::vector<std::vector<Candidate>> groups =
      GroupRegions(snapshot,
                   RegionsToEvaluate(snapshot, scope, request.options.backend),
                   request.aircraft,
                   request.options);
  const EvaluatedFlight flight = FlightOf(service, flight_id, session, snapshot);
  snapshot.obstacles = ObstaclesOf(service, flight, snapshot);
  std::vector<NewSite> sites;
  std::vector<std::string> warnings;
  for (size_t i = 0; i < groups.size(); ++i) {
    service.progress.SetArea(AreaJson(groups[i], flight.context.local_frame));
    const Evaluation evaluation = EvaluateSites(snapshot,
                                                groups[i],
                                                StoredImages(service, flight_id),
                                                request.aircraft,
                                                request.options,
                                                ShareOf(progress, i, groups.size()));
    for (const Site& site : evaluation.sites) {
      sites.push_back(SiteOf(AsStored(site), evaluation, flight));
    }
    session.AddReports(evaluation.reports);
    for (const std::string& warning : evaluation.warnings) {
      if (std::find(warnings.begin(), warnings.end(), warning) == warnings.end()) {
        warnings.push_back(warning);
      }
    }
  }
  if (sites.empty()) warnings = NoSiteReason(snapshot);
  DropDuplicates(sites);
  const size_t num_sites = sites.size();
  StoreSites(service, flight_id, std::move(sites), scope);
  service.alternates.Wake(flight_id);
  service.alternates.WakeAll();
  session.Store(service.storage);
  service.storage.flights.Change(flight_id, [&](FlightRow& row) {
    row.warnings_json = ReplaceWarnings(row.warnings_json, "evaluation", warnings);
  });
  return num_sites;
}

}  // namespace freelsd
