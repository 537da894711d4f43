#include "server/evaluation.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "api/export/export.h"
#include "server/site_lookup.h"
#include "server/stamps.h"
#include "server/warnings.h"

namespace freelsd {
namespace {

// Where other sites on the same ground may have their touchdown.
constexpr double kNeighbourhoodDeg = 0.02;

struct NewSite {
  SiteRow row;
  std::string map_blob;
  // It tells of the ground, so what others told before is out of date.
  bool is_evidence = false;
};

std::vector<Region> RegionsToEvaluate(const Snapshot& snapshot,
                                      EvaluationScope scope,
                                      const BackendOptions& options) {
  std::vector<Region> regions;
  const size_t max_num_regions = scope == EvaluationScope::kEveryGraded
                                     ? snapshot.regions.size()
                                     : static_cast<size_t>(options.num_backend_candidates);
  for (const Region& region : snapshot.regions) {  // best first
    if (region.grade > 0.0 && regions.size() < max_num_regions) regions.push_back(region);
  }
  return regions;
}

// The stored image of a frame, decoded; empty if it is gone.
ImageSource StoredImages(Service& service, const std::string& flight_id) {
  return [&service, flight_id](const std::string& frame_id) {
    const std::optional<FrameRow> frame = service.storage.FindFrame(flight_id, frame_id);
    if (!frame) return cv::Mat();
    const std::optional<std::string> bytes = service.storage.ReadImage(frame->sha256);
    if (!bytes) return cv::Mat();
    return DecodeImage(*bytes, service.image_limits);
  };
}

Replan ReplanOf(const Site& site, const FlightSession& session, int min_num_observations) {
  Replan replan;
  replan.flight = session.request();
  replan.origin = session.origin();
  replan.request.footprint = site.region.Footprint();
  replan.request.area_m2 = site.region.area_m2;
  replan.request.grade = site.region.grade;
  replan.request.num_observations = site.region.num_observations;
  replan.request.min_num_observations = min_num_observations;
  if (site.wind) replan.request.wind_in_world = site.wind->wind_in_world;
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
                    request.altitude_datum,
                    std::clamp(plan.score, 0.0, 1.0),
                    AircraftJson(request.aircraft).dump()};
}

// Of the stored map, by its corners.
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

// What a rejection says of the ground itself, not of the wind or of how often it was seen.
bool IsEvidence(const Site& site) {
  if (site.plan.verdict != Verdict::kRejected) return true;
  const RejectReason reason = site.plan.reject_reason.value_or(RejectReason::kNoTerrain);
  return reason == RejectReason::kNoSafeTouchdown || reason == RejectReason::kApproachBlocked ||
         reason == RejectReason::kLoiterBlocked || reason == RejectReason::kNotGrass;
}

NewSite SiteOf(const Site& site,
               const Evaluation& evaluation,
               const FlightSession& session,
               int min_num_observations) {
  const FlightContext context = session.Context();
  const FlightRequest& request = session.request();
  NewSite made;
  made.row.id = context.flight_id + "-r" + std::to_string(site.region.id);
  made.row.flight_id = context.flight_id;
  made.row.region_id = site.region.id;
  made.row.updated_at_us = NowUs();
  const GeoPoint touchdown = context.local_frame.GeoFromWorld(site.plan.touchdown_in_world);
  made.row.latitude_deg = touchdown.latitude_deg;
  made.row.longitude_deg = touchdown.longitude_deg;
  const std::string updated_at = Rfc3339(made.row.updated_at_us);
  made.row.feature_json =
      SiteFeature(made.row.id, site, request.aircraft, updated_at, context).dump();
  if (site.plan.approach) made.row.approach_json = ApproachJson(site.plan, context).dump();
  made.row.replan_json = ReplanJson(ReplanOf(site, session, min_num_observations));
  made.is_evidence = IsEvidence(site);
  made.row.recall = RecallOf(site, request, touchdown.altitude_m);
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

Eigen::Vector2d CenterOf(const Polygon& polygon) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& corner : polygon) sum += corner;
  return sum / std::max<double>(1.0, static_cast<double>(polygon.size()));
}

// Whether either region's middle lies within the other.
bool IsSameGround(const Replan& a, const Replan& b) {
  const LocalFrame frame_a(a.origin);
  const LocalFrame frame_b(b.origin);
  const auto holds = [](const Replan& outer,
                        const LocalFrame& outer_frame,
                        const Replan& inner,
                        const LocalFrame& inner_frame) {
    const Eigen::Vector2d center = CenterOf(inner.request.footprint);
    const GeoPoint place = inner_frame.GeoFromWorld({center.x(), center.y(), 0.0});
    return Contains(outer.request.footprint, outer_frame.WorldFromGeo(place).head<2>());
  };
  return holds(a, frame_a, b, frame_b) || holds(b, frame_b, a, frame_a);
}

// Sites of other flights on the same ground, which was seen again now.
std::vector<std::string> SupersededBy(const Service& service, const NewSite& site) {
  std::vector<std::string> ids;
  if (!site.is_evidence) return ids;
  const Replan replan = ParseReplan(site.row.replan_json);
  const BoundingBox box{site.row.longitude_deg - kNeighbourhoodDeg,
                        site.row.latitude_deg - kNeighbourhoodDeg,
                        site.row.longitude_deg + kNeighbourhoodDeg,
                        site.row.latitude_deg + kNeighbourhoodDeg};
  for (const RecallRow& other : service.storage.ListRecallable(box)) {
    if (other.flight_id == site.row.flight_id) continue;
    const std::optional<SiteRow> row = service.storage.FindSite(other.site_id);
    if (row && IsSameGround(replan, ParseReplan(row->replan_json))) ids.push_back(row->id);
  }
  return ids;
}

void StoreSites(Service& service,
                const std::string& flight_id,
                const std::vector<NewSite>& sites,
                EvaluationScope scope) {
  const std::lock_guard lock(service.sites_mutex);
  if (!service.storage.FindFlight(flight_id)) return;
  std::set<std::string> ids;
  for (const NewSite& site : sites) {
    service.storage.PutSite(site.row, site.map_blob, SupersededBy(service, site));
    ids.insert(site.row.id);
    service.events.Publish(
        "site", flight_id, nlohmann::json{{"id", site.row.id}, {"flight_id", flight_id}}.dump());
  }
  if (scope != EvaluationScope::kEveryGraded) return;
  for (const SiteRow& site : service.storage.ListSites(flight_id, std::nullopt)) {
    if (!ids.contains(site.id)) service.storage.DeleteSite(site.id);
  }
}

}  // namespace

size_t EvaluateFlight(Service& service,
                      const std::string& flight_id,
                      FlightSession& session,
                      EvaluationScope scope,
                      const Progress& progress) {
  const Snapshot snapshot = session.TakeSnapshot();
  const FlightRequest& request = session.request();
  const std::vector<Region> regions = RegionsToEvaluate(snapshot, scope, request.options.backend);
  const Evaluation evaluation = EvaluateSites(snapshot,
                                              regions,
                                              StoredImages(service, flight_id),
                                              request.aircraft,
                                              request.options,
                                              progress);
  std::vector<NewSite> sites;
  for (const Site& site : evaluation.sites) {
    sites.push_back(SiteOf(site, evaluation, session, snapshot.min_num_observations));
  }
  StoreSites(service, flight_id, sites, scope);
  service.alternates.Wake(flight_id);
  session.AddReports(evaluation.reports);
  session.Store(service.storage);
  service.storage.ChangeFlight(flight_id, [&](FlightRow& flight) {
    flight.warnings_json = ReplaceWarnings(flight.warnings_json, "evaluation", evaluation.warnings);
  });
  return sites.size();
}

}  // namespace freelsd
