#include "tests/server/following/simulated_flight.h"

#include <stdexcept>

#include <nlohmann/json.hpp>

#include "server/http/http.h"
#include "server/jobs/staged_maps.h"
#include "tests/storage/temporary_folder.h"

namespace freelsd {
namespace {

constexpr int kNumFieldCells = 300;
constexpr double kFieldCellM = 2.0;

SiteMap FieldMap(FieldState state) {
  SiteMap field;
  const double half_m = 0.5 * kFieldCellM * kNumFieldCells;
  field.map.grid = {Eigen::Vector2d(-half_m, half_m), kFieldCellM, kNumFieldCells, kNumFieldCells};
  const cv::Size size(kNumFieldCells, kNumFieldCells);
  field.map.elevation = cv::Mat1f(size, 0.0f);
  field.map.upper = cv::Mat1f(size, 0.1f);
  field.map.standard_deviation = cv::Mat1f(size, 0.1f);
  field.map.num_points = cv::Mat1f(size, 9.0f);
  field.layers.grid = field.map.grid;
  field.layers.slope = cv::Mat1f(size, 0.0f);
  field.layers.roughness = cv::Mat1f(size, 0.0f);
  field.layers.grass = cv::Mat1f(size, 0.99f);
  field.layers.hazard = cv::Mat1b(size, uchar{0});
  field.layers.distance = cv::Mat1f(size, 100.0f);
  // 30 m south of the middle, across every final from the south.
  if (state == FieldState::kWalled) {
    field.map.upper(cv::Rect(0, 165, kNumFieldCells, 2)).setTo(30.0f);
  }
  return field;
}

Replan ReplanOf(const SimulatedFlight& flight) {
  Replan replan;
  replan.flight = ParseFlightRequest(
      R"({"name":"field","aircraft":{"profile":"small"},"altitude_datum":"amsl"})");
  replan.origin = {47.0, flight.longitude_deg, 400.0};
  replan.request.footprint = {{-60, -60}, {60, -60}, {60, 60}, {-60, 60}};
  replan.request.area_m2 = 14400.0;
  replan.request.grade = 1.0;
  replan.request.num_observations = 20;
  replan.request.wind_in_world = Eigen::Vector2d(0.0, -4.0);
  return replan;
}

FlightMapRow StageField(Storage& storage, const SimulatedFlight& flight, const Replan& replan) {
  const SiteMap field = FieldMap(flight.field);
  MapHead head;
  head.flight_json = replan.flight.canonical_json;
  head.origin = replan.origin;
  head.grid = field.map.grid;
  head.camera.width_px = 320;
  head.camera.height_px = 640;
  head.camera.fx_px = head.camera.fy_px = 100.0;
  FlightMapRow row;
  row.id = flight.id + "/" + std::to_string(flight.map_number);
  row.flight_id = flight.id;
  row.altitude_datum = "amsl";
  row.box = BoxOf(head.grid, LocalFrame(head.origin));
  row.updated_at_us = flight.seen_at_us;
  row.seen_at_us = flight.seen_at_us;
  StageMap(storage, row, head, {field, cv::Mat1b(field.map.elevation.size(), uchar{2})});
  return storage.maps.Find(row.id).value();
}

// As planned on its own map, with its standing unknown.
SiteRow PlannedOn(Storage& storage, const FlightMapRow& map, const Replan& replan) {
  SiteRow site;
  site.id = map.flight_id + "-r1";
  site.flight_id = map.flight_id;
  site.region_id = 1;
  site.map_id = map.id;
  site.latitude_deg = 47.0;
  site.longitude_deg = replan.origin.longitude_deg;
  site.feature_json = R"({"properties":{}})";
  site.replan_json = ReplanJson(replan);
  site.updated_at_us = map.updated_at_us;
  site.seen_at_us = map.seen_at_us;
  site.map_box = map.box;
  site.recall = RecallData{true, 400.0, "amsl", 0.5, AircraftJson(replan.flight.aircraft).dump()};
  EvaluationRows rows;
  rows.sites = {site};
  rows.new_maps = {map.id};
  storage.sites.PutEvaluation(rows, {});
  MapCache maps({size_t{1} << 26, size_t{1} << 22});
  const auto kept = maps.Get(storage, site.id, site.updated_at_us);
  if (!kept) throw std::logic_error("the field's map cannot be read");
  const Aircraft& aircraft = replan.flight.aircraft;
  const Plan plan = maps.PlannerFor(kept, aircraft)->planner.PlanFor(replan.request.wind_in_world);
  if (!plan.approach) throw std::logic_error("nothing can land on the field");
  const FlightContext context{map.flight_id, "amsl", LocalFrame(replan.origin)};
  Site evaluated;
  evaluated.plan = plan;
  const GeoPoint touchdown = context.local_frame.GeoFromWorld(plan.touchdown_in_world);
  site.latitude_deg = touchdown.latitude_deg;
  site.longitude_deg = touchdown.longitude_deg;
  site.approach_json = ApproachJson(plan, context).dump();
  site.feature_json =
      SiteFeature(site.id, evaluated, aircraft, Rfc3339(map.updated_at_us), context).dump();
  site.recall->is_landable = plan.verdict == Verdict::kLandable;
  return site;
}

ToldChange ChangeOf(ChangeSubject subject,
                    const std::string& id,
                    int64_t stamp_us,
                    const std::string& origin) {
  ToldChange told;
  told.change.key.subject = subject;
  told.change.key.id = id;
  told.change.stamp_us = stamp_us;
  told.change.origin = origin;
  return told;
}

}  // namespace

ToldFlight Fly(const SimulatedFlight& flight) {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  const Replan replan = ReplanOf(flight);
  const FlightMapRow map = StageField(storage, flight, replan);
  ToldFlight told;
  told.map_bytes[map.id] = MapBytes(storage, map);
  ToldChange of_map = ChangeOf(ChangeSubject::kMap, map.id, map.updated_at_us, flight.origin);
  of_map.map = map;
  told.changes.push_back(of_map);
  if (!flight.has_site) return told;
  const SiteRow site = PlannedOn(storage, map, replan);
  ToldChange of_site = ChangeOf(ChangeSubject::kSite, site.id, site.updated_at_us, flight.origin);
  of_site.site = site;
  told.changes.push_back(of_site);
  return told;
}

}  // namespace freelsd
