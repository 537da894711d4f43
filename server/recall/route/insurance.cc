#include "server/recall/route/insurance.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <future>
#include <limits>
#include <map>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace freelsd {
namespace {

// A recall alone gives up earlier, but repeats what it has not planned when it is asked again. A
// route asks once.
constexpr std::chrono::milliseconds kTimeBudgetOfMoment{20000};

// A moment in one wind.
struct Outcome {
  double weight = 0.0;
  // Of the best site in reach, or of the nearest miss.
  std::optional<std::string> site_id;
  std::optional<double> margin_m;
  std::optional<double> failure_probability;
  bool is_covered = false;
  MissReason reason = MissReason::kNotEvaluated;
};

Outcome OutcomeOf(const Search& search, double weight) {
  Outcome outcome;
  outcome.weight = weight;
  outcome.is_covered = !search.reachable.empty();
  if (!outcome.is_covered) outcome.reason = ReasonOf(search);
  const Ranked* const told = outcome.is_covered    ? &search.reachable.front()
                             : search.nearest_miss ? &*search.nearest_miss
                                                   : nullptr;
  if (told == nullptr) return outcome;
  outcome.site_id = told->candidate->row->site_id;
  outcome.margin_m = told->reached.margin_m;
  if (const auto& risk = told->reached.task.plan->risk) {
    outcome.failure_probability = risk->failure_probability;
  }
  return outcome;
}

void SetBestSite(const std::vector<Outcome>& outcomes, InsuredMoment& insured) {
  std::map<std::string, double> weights;
  double greatest = 0.0;
  for (const Outcome& outcome : outcomes) {
    if (!outcome.is_covered) continue;
    const double weight = weights[*outcome.site_id] += outcome.weight;
    if (weight <= greatest) continue;
    greatest = weight;
    insured.best_site = outcome.site_id;
  }
}

void SetRisk(const std::vector<Outcome>& outcomes, InsuredMoment& insured) {
  double sum = 0.0;
  for (const Outcome& outcome : outcomes) {
    if (!outcome.is_covered || !outcome.failure_probability) return;
    sum += outcome.weight * *outcome.failure_probability;
  }
  insured.failure_probability = sum;
}

// A wind in which nothing is known is worse than any margin.
double MarginOf(const Outcome& outcome) {
  return outcome.margin_m.value_or(-std::numeric_limits<double>::infinity());
}

InsuredMoment Together(const RouteMoment& moment, const std::vector<Outcome>& outcomes) {
  InsuredMoment insured;
  insured.moment = moment;
  insured.is_covered = true;
  const Outcome* lowest = &outcomes.front();
  const Outcome* worst = &outcomes.front();
  for (const Outcome& outcome : outcomes) {
    if (outcome.is_covered) insured.covered_weight += outcome.weight;
    insured.is_covered = insured.is_covered && outcome.is_covered;
    if (MarginOf(outcome) < MarginOf(*lowest)) lowest = &outcome;
    const auto badness = [](const Outcome& of) { return std::pair(of.is_covered, MarginOf(of)); };
    if (badness(outcome) < badness(*worst)) worst = &outcome;
  }
  SetBestSite(outcomes, insured);
  SetRisk(outcomes, insured);
  insured.arrival_margin_m = lowest->margin_m;
  if (insured.is_covered) return insured;
  insured.reason = worst->reason;
  if (worst->margin_m) {
    insured.nearest_miss = {*worst->site_id, std::max(0.0, -*worst->margin_m)};
  }
  return insured;
}

constexpr size_t kNumReasons = static_cast<size_t>(MissReason::kNotEvaluated) + 1;

MissReason MostFrequent(const std::array<size_t, kNumReasons>& counts) {
  return static_cast<MissReason>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

RouteGap GapFrom(const std::vector<InsuredMoment>& moments, size_t first) {
  RouteGap gap;
  gap.first = gap.last = first;
  std::array<size_t, kNumReasons> counts{};
  for (size_t i = first; i < moments.size() && !moments[i].is_covered; ++i) {
    gap.last = i;
    ++counts[static_cast<size_t>(moments[i].reason)];
  }
  gap.reason = MostFrequent(counts);
  // Of the moments with this reason: where another one holds, another height is missing, or none.
  for (size_t i = first; i <= gap.last; ++i) {
    const auto& miss = moments[i].nearest_miss;
    if (!miss || moments[i].reason != gap.reason) continue;
    if (!gap.nearest_miss || miss->missing_m < gap.nearest_miss->missing_m) gap.nearest_miss = miss;
  }
  return gap;
}

std::vector<RouteGap> GapsOf(const std::vector<InsuredMoment>& moments) {
  std::vector<RouteGap> gaps;
  for (size_t i = 0; i < moments.size(); ++i) {
    if (moments[i].is_covered) continue;
    gaps.push_back(GapFrom(moments, i));
    i = gaps.back().last;
  }
  return gaps;
}

bool IsSameState(const RouteMoment& a, const RouteMoment& b) {
  return a.time_s == b.time_s && a.heading_deg == b.heading_deg &&
         a.place.latitude_deg == b.place.latitude_deg &&
         a.place.longitude_deg == b.place.longitude_deg && a.place.altitude_m == b.place.altitude_m;
}

// The times of the moments are those of the mean wind.
Eigen::Vector2d MeanOf(const std::vector<WeightedWind>& winds) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const WeightedWind& wind : winds) mean += wind.weight * wind.wind_in_world;
  return mean;
}

// "route[3]: …" becomes /route/3.
ApiError RouteError(const std::invalid_argument& error) {
  const std::string text = error.what();
  std::string pointer = "/" + text.substr(0, text.find(':'));
  std::replace(pointer.begin(), pointer.end(), '[', '/');
  std::erase(pointer, ']');
  return ApiError("InvalidValue", text, {{pointer, text.substr(text.find(':') + 2)}});
}

}  // namespace

size_t Insurance::NumUncovered() const {
  size_t num = 0;
  for (const RouteGap& gap : gaps) num += gap.last - gap.first + 1;
  return num;
}

RouteJudge::RouteJudge(const StoredSites& stored,
                       const RouteRequest& request,
                       std::chrono::steady_clock::time_point deadline)
    : stored_(stored), request_(request), deadline_(deadline) {}

std::vector<RouteMoment> RouteJudge::MomentsOf(const std::vector<GeoPoint>& route) const {
  try {
    return freelsd::MomentsOf(route, request_.airspeed_mps, MeanOf(request_.winds), options_);
  } catch (const std::invalid_argument& error) {
    throw RouteError(error);
  }
}

EmergencyRequest RouteJudge::RequestAt(const RouteMoment& moment,
                                       const std::optional<Eigen::Vector2d>& wind_in_world) const {
  EmergencyRequest request;
  request.place = moment.place;
  request.altitude_datum = request_.altitude_datum;
  request.flight_id = request_.flight_id;
  request.wind_in_world = wind_in_world;
  request.wind_sd_mps = request_.wind_sd_mps;
  request.is_wind_old = request_.is_wind_old;
  request.heading_deg = moment.heading_deg;
  request.glide_ratio = request_.glide_ratio;
  request.terrain_clearance_m = request_.terrain_clearance_m.value_or(request.terrain_clearance_m);
  request.arrival_height_m = request_.arrival_height_m.value_or(request.arrival_height_m);
  request.aircraft = request_.aircraft;
  request.limit = 1;
  return request;
}

InsuredMoment RouteJudge::Judge(const RouteMoment& moment) const {
  std::vector<Outcome> outcomes;
  const auto add = [&](const std::optional<Eigen::Vector2d>& wind, double weight) {
    const Search search =
        IsLate() ? Search{}
                 : SearchSites(stored_, RequestAt(moment, wind), kTimeBudgetOfMoment, fleet_);
    outcomes.push_back(OutcomeOf(search, weight));
  };
  if (request_.winds.empty()) add(std::nullopt, 1.0);
  for (const WeightedWind& wind : request_.winds) add(wind.wind_in_world, wind.weight);
  return Together(moment, outcomes);
}

Insurance RouteJudge::Insure(const std::vector<GeoPoint>& route, const Insurance& known) const {
  const std::vector<RouteMoment> moments = MomentsOf(route);
  Insurance insurance;
  insurance.moments.resize(moments.size());
  std::atomic<size_t> next = 0;
  const auto judge = [&] {
    for (size_t i = next++; i < moments.size(); i = next++) {
      const bool is_known =
          i < known.moments.size() && IsSameState(known.moments[i].moment, moments[i]);
      insurance.moments[i] = is_known ? known.moments[i] : Judge(moments[i]);
    }
  };
  // Threads of its own have the priority of the caller; those of cv::parallel_for_ that of whoever
  // came first. One processor is left to emergencies.
  std::vector<std::future<void>> others;
  for (unsigned i = 2; i < std::thread::hardware_concurrency(); ++i) {
    others.push_back(std::async(std::launch::async, judge));
  }
  judge();
  for (std::future<void>& each : others) each.get();
  insurance.gaps = GapsOf(insurance.moments);
  return insurance;
}

}  // namespace freelsd
