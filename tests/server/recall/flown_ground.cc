#include "tests/server/recall/flown_ground.h"

#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "engine/approach/approach_geometry.h"
#include "server/http/stamps.h"
#include "server/jobs/staged_maps.h"
#include "server/recall/recall.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

constexpr int kNumCells = 40;
// The whole disc is unseen.
constexpr double kUnseenM = 14.0;

// The frames of different flights lie beside each other; the grids too.
GeoPoint OriginOf(const Flown& flown) {
  const double shift_m = 0.7 * static_cast<double>(flown.flight_id.back() % 10);
  GeoPoint origin = TouchdownOf(flown);
  origin.altitude_m += flown.altitude_error_m;
  return LocalFrame(origin).GeoFromWorld({shift_m, -shift_m, 0.0});
}

Plan PlanOf(const Flown& flown, const LocalFrame& frame) {
  const Aircraft aircraft = RequestOf(flown).aircraft;
  const WindCase wind = MakeWindCase(flown.wind, aircraft, {});
  GeoPoint touchdown = TouchdownOf(flown);
  touchdown.altitude_m += flown.altitude_error_m;
  Plan plan;
  plan.verdict = Verdict::kLandable;
  plan.approach = MakeApproach(frame.WorldFromGeo(touchdown),
                               wind.headings[0].heading,
                               wind.headings[0].scenarios[0],
                               LoiterDirection::kLeft,
                               aircraft.approach_height_m);
  plan.touchdown_in_world = plan.approach->touchdown_in_world;
  ApproachProfile& profile = plan.approach->profile;
  for (double distance = std::floor(plan.approach->approach_distance); distance >= 0.0;
       --distance) {
    profile.distance.push_back(distance);
    profile.path_height.push_back(plan.touchdown_in_world.z() + 0.2 * distance);
    profile.terrain_height.push_back(plan.touchdown_in_world.z() + 0.1);
  }
  return plan;
}

bool IsWithin(const Eigen::Vector2d& place, const Eigen::Vector2d& middle, double half_m) {
  return (place - middle).cwiseAbs().maxCoeff() <= half_m;
}

struct CellFound {
  double height = 0.1;
  double slope = 0.0;
  double grass = 0.99;
  bool is_seen = true;
};

CellFound FindAt(const Flown& flown, const Eigen::Vector2d& from_middle) {
  const auto tree = [&](double east, double north) {
    return IsWithin(from_middle, {east, north}, 4.0) ? flown.tree_m : 0.1;
  };
  CellFound cell;
  switch (flown.ground) {
    case Ground::kFree:
      break;
    case Ground::kHazardInDisc:
      if (IsWithin(from_middle, {7.0, 0.0}, 4.0)) cell.grass = 0.0;
      break;
    case Ground::kHazardAside:
      if (IsWithin(from_middle, {26.0, 0.0}, 4.0)) cell.grass = 0.0;
      break;
    case Ground::kSlope:
      if (IsWithin(from_middle, {0.0, 0.0}, 6.0)) cell.slope = RadFromDeg(6.0);
      break;
    case Ground::kTreeOnFinal:
      cell.height = tree(0.0, -30.0);
      break;
    case Ground::kTreeOnCircle:
      cell.height = tree(-68.0, -46.0);
      break;
    case Ground::kTreeAside:
      cell.height = tree(70.0, 60.0);
      break;
    case Ground::kDiscUnseen:
      cell.is_seen = from_middle.norm() > kUnseenM;
      break;
    case Ground::kDiscUnseenTree:
      cell.is_seen = from_middle.norm() > kUnseenM;
      cell.height = tree(0.0, -30.0);
      break;
  }
  return cell;
}

SiteMap EmptyMap(const Flown& flown) {
  SiteMap made;
  const double size_m = 2.0 * flown.half_size_m / kNumCells;
  made.map.grid = {flown.map_shift + Eigen::Vector2d(-flown.half_size_m, flown.half_size_m),
                   size_m,
                   kNumCells,
                   kNumCells};
  const cv::Size size(kNumCells, kNumCells);
  constexpr float kUnseenCell = std::numeric_limits<float>::quiet_NaN();
  for (cv::Mat1f* layer : {&made.map.elevation,
                           &made.map.upper,
                           &made.map.standard_deviation,
                           &made.map.num_points,
                           &made.layers.slope,
                           &made.layers.roughness,
                           &made.layers.grass}) {
    *layer = cv::Mat1f(size, kUnseenCell);
  }
  made.map.is_compared = true;
  made.layers.grid = made.map.grid;
  made.layers.hazard = cv::Mat1b(size, uchar{kUnseen});
  made.layers.distance = cv::Mat1f(size, 0.0f);
  return made;
}

}  // namespace

FlightRequest RequestOf(const Flown& flown) {
  const std::string strict =
      flown.is_strict ? R"(,"max_slope_deg":4,"touchdown_uncertainty_m":9)" : "";
  const std::string loose = flown.is_loose ? R"(,"safety_margin_m":1)" : "";
  const std::string memory = flown.is_experiment ? R"(,"memory":"none")" : "";
  return ParseFlightRequest(R"({"name":"field of )" + flown.flight_id +
                            R"(","aircraft":{"profile":"small","approach_height_m":)" +
                            std::to_string(flown.approach_height_m) + strict + loose +
                            R"(},"altitude_datum":")" + flown.altitude_datum + '"' + memory + "}");
}

FlightRow FlightOf(const Flown& flown) {
  FlightRow flight;
  flight.id = flown.flight_id;
  flight.name = "field of " + flown.flight_id;
  flight.request_json = RequestOf(flown).canonical_json;
  flight.created_at_us = flown.seen_at_us;
  return flight;
}

std::string IdOf(const Flown& flown) {
  return flown.flight_id + "-r" + std::to_string(flown.region_id);
}

GeoPoint TouchdownOf(const Flown& flown) {
  return {flown.latitude_deg + 0.04 * flown.place, flown.longitude_deg, 400.0};
}

SiteRow SiteOf(const Flown& flown) {
  const LocalFrame frame(OriginOf(flown));
  Replan replan;
  replan.flight = RequestOf(flown);
  replan.origin = frame.origin();
  const double half_m = flown.half_region_m;
  replan.request = {
      .footprint = {{-half_m, -half_m}, {half_m, -half_m}, {half_m, half_m}, {-half_m, half_m}},
      .area_m2 = 1600.0,
      .grade = 1.0,
      .num_observations = 9,
      .wind_in_world = flown.wind};
  const GeoPoint touchdown = TouchdownOf(flown);
  const double altitude_m = touchdown.altitude_m + flown.altitude_error_m;
  SiteRow site;
  site.id = IdOf(flown);
  site.flight_id = flown.flight_id;
  site.region_id = flown.region_id;
  site.latitude_deg = touchdown.latitude_deg;
  site.longitude_deg = touchdown.longitude_deg;
  site.updated_at_us = flown.updated_at_us;
  site.seen_at_us = flown.seen_at_us;
  site.seen_until_us = flown.seen_until_us;
  const nlohmann::json position{touchdown.longitude_deg, touchdown.latitude_deg, altitude_m};
  site.feature_json = nlohmann::json{
      {"type", "Feature"},
      {"geometry", {{"type", "Point"}, {"coordinates", position}}},
      {"properties",
       {{"id", site.id},
        {"verdict", flown.is_accepted ? "landable" : "rejected"},
        {"last_seen_at", Rfc3339(flown.seen_at_us)},
        {"score", 0.5}}}}.dump();
  site.replan_json = ReplanJson(replan);
  site.map_box = BoxOf(EmptyMap(flown).map.grid, frame);
  if (!flown.is_accepted) return site;
  const FlightContext context{flown.flight_id, flown.altitude_datum, frame};
  site.approach_json = ApproachJson(PlanOf(flown, frame), context).dump();
  site.recall = RecallData{
      true, altitude_m, flown.altitude_datum, 0.5, AircraftJson(replan.flight.aircraft).dump()};
  return AsRemembered(site, replan.flight.memory);
}

SiteMap MapOf(const Flown& flown) {
  const LocalFrame frame(OriginOf(flown));
  GeoPoint touchdown = TouchdownOf(flown);
  touchdown.altitude_m += flown.altitude_error_m;
  Eigen::Vector3d middle = frame.WorldFromGeo(touchdown);
  middle.head<2>() += flown.map_shift;
  SiteMap made = EmptyMap(flown);
  for (int row = 0; row < kNumCells; ++row) {
    for (int col = 0; col < kNumCells; ++col) {
      const Eigen::Vector2d place = made.map.grid.CellCenter(row, col);
      const CellFound cell = FindAt(flown, place - middle.head<2>());
      if (!cell.is_seen) continue;
      made.map.elevation(row, col) = static_cast<float>(middle.z());
      made.map.upper(row, col) = static_cast<float>(middle.z() + cell.height);
      made.map.standard_deviation(row, col) = 0.1f;
      made.map.num_points(row, col) = 9.0f;
      made.layers.slope(row, col) = static_cast<float>(cell.slope);
      made.layers.roughness(row, col) = 0.0f;
      made.layers.grass(row, col) = static_cast<float>(cell.grass);
      made.layers.hazard(row, col) = uchar{kFree};
    }
  }
  return made;
}

void Store(Storage& storage, MapCache& maps, const Flown& flown) {
  EvaluationRows rows = RowsOnMap(storage, SiteOf(flown), MapOf(flown));
  const std::unique_ptr<SiteTurn> turn = storage.sites.TakeTurn();
  StoreEvaluation(storage, maps, *turn, std::move(rows));
}

FlownServer::FlownServer(const std::vector<Flown>& flights)
    : MeadowServer([&flights](Storage& storage) {
        MapCache maps({size_t{1} << 24, size_t{1} << 22});
        for (const Flown& flown : flights) {
          if (flown.is_experiment) storage.flights.Insert(FlightOf(flown));
          Store(storage, maps, flown);
        }
      }) {}

nlohmann::json FlownServer::Site(const std::string& id) const {
  return GetJson(*client, "/v1/sites/" + id)["properties"];
}

}  // namespace freelsd
