#include "tests/evaluation/flown/insured_routes.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/recall/route/insurance.h"
#include "server/recall/route/route.h"
#include "tests/evaluation/scores/flown_site.h"

namespace freelsd {
namespace {

// Routes stay this far inside the outer edge of the mosaic.
constexpr double kBorderM = 150.0;
constexpr double kLowestM = 40.0;
constexpr double kHighestM = 160.0;
constexpr double kMinLegM = 300.0;
constexpr double kMaxWindMps = 6.0;
constexpr double kWindSdMps = 1.0;
constexpr double kAirspeedMps = 15.0;

class Dice {
 public:
  explicit Dice(std::mt19937& random) : random_(random) {}
  double Between(double least, double most) {
    return least + (most - least) * std::uniform_real_distribution<double>(0.0, 1.0)(random_);
  }

 private:
  std::mt19937& random_;
};

// East, north from the mosaic's origin: the corners of what all its worlds cover.
std::pair<Eigen::Vector2d, Eigen::Vector2d> ExtentOf(const Mosaic& mosaic) {
  const LocalFrame frame(mosaic.origin());
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
  for (const World& world : mosaic.worlds()) {
    const Eigen::Vector2d middle = frame.WorldFromGeo(world.origin).head<2>();
    const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * world.size_m);
    low = low.cwiseMin(middle - half);
    high = high.cwiseMax(middle + half);
  }
  return {low, high};
}

// In the world's frame.
Plan PlanInWorld(const Plan& plan, const LocalFrame& plan_frame, const World& world) {
  const LocalFrame world_frame(world.origin);
  const auto moved = [&](const Eigen::Vector3d& place) {
    return world_frame.WorldFromGeo(plan_frame.GeoFromWorld(place));
  };
  Plan in_world = plan;
  in_world.touchdown_in_world = moved(plan.touchdown_in_world);
  Approach& approach = *in_world.approach;
  approach.touchdown_in_world = moved(approach.touchdown_in_world);
  approach.approach_start_in_world = moved(approach.approach_start_in_world);
  return in_world;
}

// What Land needs of a plan is the final.
double FailureOf(const FlownSite& flown) {
  return static_cast<double>(flown.num_failed) / std::max(1, flown.num_flown);
}

}  // namespace

RouteRequest RandomRoute(const Mosaic& mosaic, std::mt19937& random) {
  Dice dice(random);
  const auto [low, high] = ExtentOf(mosaic);
  const LocalFrame frame(mosaic.origin());
  RouteRequest request;
  request.altitude_datum = "amsl";
  request.airspeed_mps = kAirspeedMps;
  request.aircraft = AircraftProfile("small");
  const auto num_points = static_cast<size_t>(std::lround(dice.Between(1.5, 5.5)));
  std::vector<Eigen::Vector2d> places;
  while (places.size() < num_points) {
    const Eigen::Vector2d place(dice.Between(low.x() + kBorderM, high.x() - kBorderM),
                                dice.Between(low.y() + kBorderM, high.y() - kBorderM));
    if (!places.empty() && (place - places.back()).norm() < kMinLegM) continue;
    places.push_back(place);
    GeoPoint point = frame.GeoFromWorld({place.x(), place.y(), 0.0});
    point.altitude_m = mosaic.origin().altitude_m + dice.Between(kLowestM, kHighestM);
    request.route.push_back(point);
  }
  const Eigen::Vector2d wind =
      dice.Between(0.0, kMaxWindMps) * DirectionOf(dice.Between(0.0, 2.0 * kPi));
  nlohmann::json object{{"route", nlohmann::json::array()}, {"airspeed_mps", kAirspeedMps}};
  for (const GeoPoint& point : request.route) object["route"].push_back(GeoPointJson(point));
  object["wind"] = {{"east_mps", wind.x()}, {"north_mps", wind.y()}};
  if (dice.Between(0.0, 1.0) < 0.5) object["wind"]["sd_mps"] = kWindSdMps;
  request.winds = ParseRouteRequest(object).winds;
  return request;
}

RouteFlyer::RouteFlyer(const StoredSites& stored, const Mosaic& mosaic)
    : stored_(stored), mosaic_(mosaic), recalled_(stored, mosaic) {}

FlownRoute RouteFlyer::Fly(const RouteRequest& request, int num_stops, uint64_t seed) {
  FlownRoute flown;
  const auto begin = std::chrono::steady_clock::now();
  const nlohmann::json answer = CheckRoute(stored_, request);
  flown.check_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const nlohmann::json& samples = answer.at("samples");
  flown.num_seconds = static_cast<int>(samples.size());
  for (const nlohmann::json& sample : samples) {
    flown.num_covered_seconds += sample.at("covered").get<bool>();
  }
  flown.num_gaps = static_cast<int>(answer.at("gaps").size());
  for (const nlohmann::json& fix : answer.at("fixes")) ++flown.fixes[fix.at("kind")];
  flown.num_wrong_fixes = CountWrongFixes(request, answer);
  std::mt19937 random(static_cast<uint32_t>(seed));
  std::vector<double> weights;
  std::vector<Eigen::Vector2d> winds;
  for (const WeightedWind& wind : request.winds) {
    weights.push_back(wind.weight);
    winds.push_back(wind.wind_in_world);
  }
  std::discrete_distribution<size_t> draw_wind(weights.begin(), weights.end());
  std::uniform_int_distribution<size_t> draw_second(0, samples.size() - 1);
  for (int i = 0; i < num_stops; ++i) {
    // The wind that truly blows comes first.
    std::rotate(
        winds.begin(), winds.begin() + static_cast<std::ptrdiff_t>(draw_wind(random)), winds.end());
    Stop(request, samples[draw_second(random)], winds, flown);
    winds.clear();
    for (const WeightedWind& wind : request.winds) winds.push_back(wind.wind_in_world);
  }
  return flown;
}

// The sample must be what recalls in all winds answer, one by one.
void RouteFlyer::Stop(const RouteRequest& request,
                      const nlohmann::json& sample,
                      const std::vector<Eigen::Vector2d>& winds,
                      FlownRoute& flown) {
  ++flown.num_moments;
  const RouteJudge judge(stored_, request, std::chrono::steady_clock::time_point::max());
  RouteMoment moment;
  moment.place = {sample.at("latitude_deg"), sample.at("longitude_deg"), sample.at("altitude_m")};
  moment.heading_deg = sample.at("heading_deg");
  bool is_covered = true;
  bool is_known = true;
  double least_m = std::numeric_limits<double>::infinity();
  nlohmann::json site;
  for (const Eigen::Vector2d& wind : winds) {
    const nlohmann::json answer = RecallSites(stored_, judge.RequestAt(moment, wind));
    const bool has_site = !answer.at("sites").empty();
    is_covered = is_covered && has_site;
    const nlohmann::json told =
        has_site ? answer["sites"][0] : answer.value("nearest_miss", nlohmann::json());
    // A wind in which nothing could be evaluated is worse than any margin.
    is_known = is_known && !told.is_null();
    if (is_known) least_m = std::min(least_m, told.at("arrival_margin_m").get<double>());
    if (site.is_null() && has_site) site = told;
  }
  const nlohmann::json margin = is_known ? nlohmann::json(least_m) : nlohmann::json();
  flown.num_different +=
      is_covered != sample.at("covered").get<bool>() || sample.at("arrival_margin_m") != margin;
  if (!sample.at("covered").get<bool>()) return;
  ++flown.num_covered;
  flown.told_risk += sample.value("failure_probability", 1.0);
  Land(judge.RequestAt(moment, winds.front()), site, flown);
}

void RouteFlyer::Land(const EmergencyRequest& request,
                      const nlohmann::json& site,
                      FlownRoute& flown) {
  if (site.contains("path")) {
    const FlownPath path = recalled_.Fly(request, site);
    if (path.obstacle != Obstacle::kNone && path.obstacle != Obstacle::kOnFinal) {
      ++flown.met[path.obstacle];
      flown.num_failed += 1.0;
      flown.remarks.push_back("site " + path.site_id + ": met " + CoverName(path.cover) +
                              (path.is_wire ? " (wire)" : ""));
      return;
    }
  }
  GlidingFleet fleet;
  const Search search = SearchSites(stored_, request, std::chrono::milliseconds(1000000), fleet);
  const DescentTask& task = search.reachable.front().reached.task;
  const MosaicPlace there =
      mosaic_.PlaceOf(task.local_frame.GeoFromWorld(task.plan->touchdown_in_world));
  World world = *there.world;
  world.wind_in_world = *request.wind_in_world;
  Site landed;
  landed.plan = PlanInWorld(*task.plan, task.local_frame, world);
  const FlownSite flights =
      FlySite(world, TruthOf(*there.world, task.aircraft), task.aircraft, landed, 1);
  flown.num_failed += FailureOf(flights);
  flown.num_failed_thin +=
      static_cast<double>(flights.num_failed_thin) / std::max(1, flights.num_flown);
}

const TruthMap& RouteFlyer::TruthOf(const World& world, const Aircraft& aircraft) {
  const auto found = truths_.find(&world);
  if (found != truths_.end()) return found->second;
  return truths_.emplace(&world, MakeTruthMap(world, aircraft)).first->second;
}

int RouteFlyer::CountWrongFixes(const RouteRequest& request, const nlohmann::json& answer) const {
  int num_wrong = 0;
  for (const nlohmann::json& fix : answer.at("fixes")) {
    if (!fix.contains("route")) continue;
    RouteRequest changed = request;
    changed.has_fixes = false;
    changed.route.clear();
    for (const nlohmann::json& point : fix.at("route")) {
      changed.route.push_back(
          {point.at("latitude_deg"), point.at("longitude_deg"), point.at("altitude_m")});
    }
    double gaps_s = 0.0;
    const nlohmann::json checked = CheckRoute(stored_, changed);
    for (const nlohmann::json& gap : checked.at("gaps")) {
      gaps_s += gap.at("to_s").get<double>() - gap.at("from_s").get<double>();
    }
    num_wrong += gaps_s != fix.at("gaps_left_s").get<double>();
  }
  return num_wrong;
}

}  // namespace freelsd
