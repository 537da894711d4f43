#include "server/recall/recall_sites.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/http/http.h"
#include "server/recall/descent_path.h"
#include "server/recall/obstacles/obstacles.h"
#include "server/recall/own_sites.h"
#include "server/recall/site_search.h"
#include "server/recall/standing.h"

namespace freelsd {
namespace {

// After this time an answer begins no further plan.
constexpr std::chrono::milliseconds kTimeBudget{1500};

nlohmann::json PlaceOf(const GeoPoint& place) {
  return {{"latitude_deg", place.latitude_deg},
          {"longitude_deg", place.longitude_deg},
          {"altitude_m", place.altitude_m}};
}

nlohmann::json ApproachOf(const Plan& plan, const FlightContext& context) {
  nlohmann::json approach = PlanProperties(plan, context)["approach"];
  approach["start"] =
      PlaceOf(context.local_frame.GeoFromWorld(plan.approach->approach_start_in_world));
  approach["loiter_center"] =
      PlaceOf(context.local_frame.GeoFromWorld(plan.approach->loiter_center_in_world));
  return approach;
}

// In [0, 360).
double BearingDeg(const Eigen::Vector2d& way) {
  const double bearing_deg = DegFromRad(HeadingOf(way));
  return bearing_deg < 0.0 ? bearing_deg + 360.0 : bearing_deg;
}

// Why the site is less than its plan says, and that it is of an experiment.
std::vector<std::string> StandingWarnings(const EmergencyRequest& request,
                                          const RecallRow& row,
                                          const Plan& plan) {
  std::vector<std::string> warnings;
  if (row.doubt) {
    warnings.push_back(DoubtSentence(*row.doubt));
  } else if (!plan.reject_detail.empty()) {
    warnings.push_back("Doubted: " + plan.reject_detail);
  }
  if (IsOwnExperiment(request, row)) warnings.emplace_back(kExperimentWarning);
  return warnings;
}

nlohmann::json AnswerOf(const EmergencyRequest& request,
                        const RecallCandidate& candidate,
                        const DescentTask& task) {
  const GeoPoint& place = request.place;
  const Plan& plan = *task.plan;
  const bool is_landable = plan.verdict == Verdict::kLandable && !candidate.row->doubt;
  const FlightContext context{
      candidate.row->flight_id, candidate.row->data.altitude_datum, task.local_frame};
  const GeoPoint touchdown = task.local_frame.GeoFromWorld(plan.touchdown_in_world);
  const Eigen::Vector2d way = LocalFrame(place).WorldFromGeo(touchdown).head<2>();
  nlohmann::json answer{{"site_id", candidate.row->site_id},
                        {"flight_id", candidate.row->flight_id},
                        {"verdict", is_landable ? "landable" : "unverified"},
                        {"unseen_ratio", plan.approach->unseen_ratio},
                        {"distance_m", way.norm()},
                        {"bearing_deg", BearingDeg(way)},
                        {"datum_penalty_m", candidate.datum.subtracted_m},
                        {"time_s", task.worst.time_s},
                        {"score", candidate.score},
                        {"score_when_stored", candidate.row->data.score},
                        {"updated_at", Rfc3339(candidate.row->updated_at_us)},
                        {"altitude_datum", candidate.row->data.altitude_datum},
                        {"aircraft", AircraftJson(task.aircraft)},
                        {"warnings", LimitsWarnings(task.aircraft)},
                        {"touchdown", PlaceOf(touchdown)},
                        {"approach", ApproachOf(plan, context)}};
  answer.update(GroundAgeJson(candidate.row->seen_at_us, NowUs()));
  for (std::string& warning : StandingWarnings(request, *candidate.row, plan)) {
    answer["warnings"].push_back(std::move(warning));
  }
  if (candidate.row->doubt) {
    const int64_t since_us = candidate.row->doubt->superseded_at_us;
    answer["doubted_at"] = since_us > 0 ? nlohmann::json(Rfc3339(since_us)) : nlohmann::json();
  }
  if (IsOwnExperiment(request, *candidate.row)) answer["memory"] = "none";
  if (plan.risk) answer["failure_probability"] = plan.risk->failure_probability;
  if (plan.approach->ground_speed) answer["ground_speed_mps"] = *plan.approach->ground_speed;
  return answer;
}

// A site of the answer, and the datums that it depends on.
struct ToldSite {
  nlohmann::json answer;
  std::set<DatumBasis> datum_bases;
};

// Planning its path takes longer than choosing the site: sites that are not told need none.
ToldSite Tell(const StoredSites& stored,
              const EmergencyRequest& request,
              const RecallCandidate& candidate,
              const Reached& reached) {
  ToldSite told{AnswerOf(request, candidate, reached.task), reached.datum_bases};
  told.answer["arrival_margin_m"] = reached.margin_m;
  told.answer["reachable"] = reached.margin_m >= 0.0;
  std::optional<TerrainMargin> terrain = reached.terrain;
  PathObstacles obstacles = reached.obstacles;
  if (reached.shortest) {
    const ToldPath path = PathToTell(stored,
                                     request,
                                     candidate,
                                     reached.task,
                                     {*reached.shortest, reached.terrain, reached.obstacles, 0.0});
    AddPath(path, reached.task.local_frame, told.answer);
    terrain = path.terrain;
    obstacles = path.obstacles;
  }
  AddObstacles(obstacles, told.answer);
  if (!reached.shortest && reached.margin_m >= 0.0) {
    told.answer["warnings"].push_back(
        "no path is given: the margin counts on the longest turns, but no single path was found");
  }
  if (terrain) {
    told.answer["terrain_margin_m"] = terrain->margin_m;
    told.answer["terrain_datum_penalty_m"] = terrain->datum.subtracted_m;
    told.datum_bases.insert(terrain->datum.basis);
  }
  return told;
}

std::vector<std::string> DatumWarnings(const EmergencyRequest& request,
                                       const std::set<DatumBasis>& bases) {
  std::vector<std::string> warnings;
  const bool is_unknown = request.altitude_datum.value_or("unknown") == "unknown";
  if (bases.contains(DatumBasis::kUnknown) || (is_unknown && !request.flight_id)) {
    warnings.emplace_back(
        "the datum of the altitude, or of stored sites or maps, is unknown: the height of the "
        "geoid "
        "is subtracted there (datum_penalty_m, terrain_datum_penalty_m)");
  }
  if (bases.contains(DatumBasis::kNoGeoid)) {
    warnings.push_back(
        "the height of the geoid is unknown, because PROJ has no grid egm96_15.gtx: " +
        std::to_string(std::lround(GlideOptions{}.datum_penalty_m)) +
        " m are subtracted where datums differ or are unknown");
  }
  return warnings;
}

std::vector<std::string> WarningsOf(const EmergencyRequest& request,
                                    const std::set<DatumBasis>& bases) {
  std::vector<std::string> warnings = DatumWarnings(request, bases);
  if (request.wind_warning) warnings.push_back(*request.wind_warning);
  if (!request.wind_in_world) {
    warnings.push_back(
        "the wind is unknown: the worst direction of a wind of 5.5 m/s is assumed, and "
        "approaches are planned for an unknown wind");
  }
  if (!request.heading_deg) warnings.push_back("no heading is given: the worst turn is assumed");
  warnings.push_back(
      "terrain on the way is known only where stored maps cover it (terrain_margin_m)");
  return warnings;
}

}  // namespace

nlohmann::json RecallSites(const StoredSites& stored, const EmergencyRequest& request) {
  const auto hold = stored.storage.HoldVersions();
  GlidingFleet fleet;
  Search search = SearchSites(stored, request, kTimeBudget, fleet);
  nlohmann::json answer{{"sites", nlohmann::json::array()}};
  const auto tell = [&](const Ranked& ranked) {
    ToldSite told = Tell(stored, request, *ranked.candidate, ranked.reached);
    search.datum_bases.merge(told.datum_bases);
    return std::move(told.answer);
  };
  for (const size_t index : DifferentPlaces(search, request.limit)) {
    answer["sites"].push_back(tell(search.reachable[index]));
    answer["sites"].back()["rank"] = answer["sites"].size();
  }
  if (search.reachable.empty() && search.nearest_miss) {
    answer["nearest_miss"] = tell(*search.nearest_miss);
    answer["nearest_miss"]["missing_m"] = -search.nearest_miss->reached.margin_m;
  }
  std::vector<std::string> warnings = WarningsOf(request, search.datum_bases);
  if (search.num_without_approach > 0) {
    warnings.push_back(std::to_string(search.num_without_approach) +
                       " nearer stored sites have no approach in this wind that clears terrain "
                       "and obstacles");
  }
  if (const int64_t count =
          stored.storage.sites.CountOverruled(BoxAround(request.place, search.reach_m))) {
    warnings.push_back(std::to_string(count) +
                       " sites nearby are left out: their stored approach fails on a map that is "
                       "later, or may be");
  }
  if (search.is_cut_short) warnings.push_back("not every stored site in reach was evaluated");
  for (const std::string& notice : stored.storage.Notices()) warnings.push_back(notice);
  answer["warnings"] = warnings;
  return answer;
}

}  // namespace freelsd
