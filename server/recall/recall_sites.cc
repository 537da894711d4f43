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
#include "server/recall/recall_candidates.h"
#include "server/recall/site_search.h"
#include "server/recall/standing.h"

namespace freelsd {
namespace {

// After this time an answer begins no further plan.
constexpr std::chrono::milliseconds kTimeBudget{1500};

nlohmann::json ApproachOf(const Plan& plan, const FlightContext& context) {
  nlohmann::json approach = PlanProperties(plan, context)["approach"];
  approach["start"] =
      GeoPointJson(context.local_frame.GeoFromWorld(plan.approach->approach_start_in_world));
  approach["loiter_center"] =
      GeoPointJson(context.local_frame.GeoFromWorld(plan.approach->loiter_center_in_world));
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
                        {"touchdown", GeoPointJson(touchdown)},
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

// Where height is missing, the surplus height of the path in the expected wind says nothing.
void AddHeights(const Reached& reached, nlohmann::json& answer) {
  answer["arrival_margin_m"] = reached.margin_m;
  answer["reachable"] = reached.IsReachable();
  if (reached.margin_m < 0.0) {
    answer["missing_m"] = -reached.margin_m;
  } else if (reached.path.descent) {
    answer["surplus_height_m"] = reached.path.SurplusM();
  } else {
    answer["warnings"].push_back(
        "no path is given: the margin counts on the longest turns, but no single path was found");
  }
  if (reached.IsReachable()) return;
  answer["reason"] = NameOf(ReasonOf(reached));
  answer["sentence"] = SentenceOf(reached);
}

nlohmann::json Tell(const EmergencyRequest& request, const Ranked& ranked) {
  const Reached& reached = ranked.reached;
  nlohmann::json answer = AnswerOf(request, *ranked.candidate, reached.task);
  AddHeights(reached, answer);
  AddPath(reached.path, reached.task.local_frame, answer);
  AddObstacles(reached.path.obstacles, answer);
  if (const auto& terrain = reached.path.terrain) {
    answer["terrain_margin_m"] = terrain->margin_m;
    answer["terrain_datum_penalty_m"] = terrain->datum.subtracted_m;
  }
  return answer;
}

// "1 stored site nearby has", "3 stored sites nearby have"
std::string StoredSitesHave(int64_t count, const char* which) {
  return std::to_string(count) + which + (count == 1 ? " stored site" : " stored sites") +
         " nearby " + (count == 1 ? "has" : "have");
}

// What an answer consists of; its sentences are made of nothing else.
struct Found {
  const EmergencyRequest& request;
  const Search& search;
  size_t num_sites = 0;
  // Of sites nearby that a map refutes which is later, or may be.
  int64_t num_overruled = 0;

  bool IsNothing() const { return num_sites == 0 && !search.nearest_miss; }
};

std::vector<std::string> LeftOut(const Found& found) {
  std::vector<std::string> left_out;
  const char* const which = found.IsNothing() ? "" : " other";
  if (const auto count = static_cast<int64_t>(found.search.num_without_approach); count > 0) {
    left_out.push_back(StoredSitesHave(count, which) +
                       " no approach in this wind that clears terrain and obstacles");
  }
  if (found.num_overruled > 0) {
    left_out.push_back(StoredSitesHave(found.num_overruled, which) +
                       " an approach that fails on a map that is later, or may be");
  }
  if (found.search.is_cut_short) {
    left_out.emplace_back("not every stored site in reach was evaluated");
  }
  return left_out;
}

std::string SummaryOf(const Found& found) {
  if (found.num_sites > 0) {
    return found.num_sites == 1 ? "1 site in reach"
                                : std::to_string(found.num_sites) + " sites in reach";
  }
  std::string summary = "no site in reach";
  if (found.search.nearest_miss) {
    return summary + ": at the closest miss " + SentenceOf(found.search.nearest_miss->reached);
  }
  const std::vector<std::string> left_out = LeftOut(found);
  if (left_out.empty()) return summary + ": no usable site is stored nearby";
  for (const std::string& reason : left_out) {
    summary += (&reason == &left_out.front() ? ": " : "; ") + reason;
  }
  return summary;
}

// What the unknown datums cost at most, over all candidates.
std::string DatumCost(const Search& search) {
  double most_m = 0.0;
  for (const RecallCandidate& candidate : search.candidates) {
    if (candidate.datum.basis != DatumBasis::kUnknown) continue;
    most_m = std::max(most_m, candidate.datum.subtracted_m);
  }
  if (most_m == 0.0) return "the height of the geoid is subtracted there";
  return "up to " + std::to_string(std::lround(most_m)) +
         " m, the height of the geoid, are subtracted there";
}

std::vector<std::string> DatumWarnings(const Found& found) {
  const std::set<DatumBasis>& bases = found.search.datum_bases;
  std::vector<std::string> warnings;
  const bool is_unknown = found.request.altitude_datum.value_or("unknown") == "unknown";
  if (bases.contains(DatumBasis::kUnknown) || (is_unknown && !found.request.flight_id)) {
    warnings.push_back("the datum of the altitude, or of stored sites or maps, is unknown: " +
                       DatumCost(found.search));
  }
  if (bases.contains(DatumBasis::kNoGeoid)) {
    warnings.push_back(
        "the height of the geoid is unknown, because PROJ has no grid egm96_15.gtx: " +
        std::to_string(std::lround(GlideOptions{}.datum_penalty_m)) +
        " m are subtracted where datums differ or are unknown");
  }
  return warnings;
}

std::vector<std::string> WarningsOf(const Found& found) {
  const EmergencyRequest& request = found.request;
  std::vector<std::string> warnings = DatumWarnings(found);
  if (request.wind_warning) warnings.push_back(*request.wind_warning);
  if (!request.wind_in_world) {
    warnings.push_back(
        "the wind is unknown: the worst direction of a wind of 5.5 m/s is assumed, and "
        "approaches are planned for an unknown wind");
  }
  if (!request.heading_deg) warnings.push_back("no heading is given: the worst turn is assumed");
  warnings.push_back("terrain on the way is known only where stored maps cover it");
  // The summary has them where there is nothing else.
  if (found.IsNothing()) return warnings;
  for (std::string& each : LeftOut(found)) warnings.push_back(std::move(each));
  return warnings;
}

}  // namespace

nlohmann::json RecallSites(const StoredSites& stored, const EmergencyRequest& request) {
  const auto hold = stored.storage.HoldVersions();
  GlidingFleet fleet;
  Search search = SearchSites(stored, request, kTimeBudget, fleet);
  nlohmann::json answer{{"sites", nlohmann::json::array()}};
  for (const size_t index : DifferentPlaces(search, request.limit)) {
    answer["sites"].push_back(Tell(request, search.reachable[index]));
    answer["sites"].back()["rank"] = answer["sites"].size();
  }
  if (!search.reachable.empty()) search.nearest_miss.reset();
  if (search.nearest_miss) answer["nearest_miss"] = Tell(request, *search.nearest_miss);
  const Found found{request,
                    search,
                    answer["sites"].size(),
                    stored.storage.sites.CountOverruled(BoxAround(request.place, search.reach_m))};
  answer["summary"] = SummaryOf(found);
  answer["wires_known"] = AreWiresKnown(stored, {request.place});
  answer["warnings"] = WarningsOf(found);
  for (const std::string& notice : stored.storage.Notices()) answer["warnings"].push_back(notice);
  return answer;
}

}  // namespace freelsd
