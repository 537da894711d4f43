#include "tests/evaluation/scores/landing_risks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "engine/risk/risk.h"
#include "tests/evaluation/scores/flown_site.h"
#include "tests/evaluation/statistics.h"
#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

// Bins of the expected risk, two a decade; the first holds everything below.
constexpr std::array<double, 7> kRiskEdges{0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.1};
constexpr int kNumDrawn = 6000;
constexpr int kMostInBin = 40;

size_t BinOf(double risk) {
  return static_cast<size_t>(
      std::find_if(kRiskEdges.begin(), kRiskEdges.end(), [&](double edge) { return risk < edge; }) -
      kRiskEdges.begin());
}

std::string NameOfBin(double edge) {
  std::ostringstream name;
  name << "below " << std::fixed << std::setprecision(3) << edge;
  return name.str();
}

PlannedLanding LandingOf(const Approach& approach, const Site& site, double position_sd_m) {
  return {.touchdown_in_world = approach.touchdown_in_world,
          .heading = approach.heading,
          .approach_distance = approach.approach_distance,
          .approach_height = approach.approach_height,
          .ground_speed = approach.ground_speed.value_or(0.0),
          .wind_spread_mps = site.wind ? site.wind->spread_mps : 0.0,
          .position_sd_m = position_sd_m};
}

// A site with a touchdown at a random cell, landed on into the wind.
std::optional<Site> DrawnSite(const EngineRun& run, const Scenario& scenario, uint64_t seed) {
  const ElevationMap& map = run.evaluation.map;
  const int row = static_cast<int>(Uniform(seed, 1, 0.0, map.grid.num_rows));
  const int col = static_cast<int>(Uniform(seed, 2, 0.0, map.grid.num_cols));
  if (row >= map.grid.num_rows || col >= map.grid.num_cols) return std::nullopt;
  if (run.evaluation.hazards.hazard(row, col) == kUnseen) return std::nullopt;
  const Eigen::Vector2d place = map.grid.CellCenter(row, col);
  if (place.cwiseAbs().maxCoeff() > 0.5 * scenario.world.size_m) return std::nullopt;
  Site site;
  site.wind = run.evaluation.wind;
  const Eigen::Vector2d wind = site.wind ? site.wind->wind_in_world : scenario.world.wind_in_world;
  const double length = ApproachDistance(scenario.aircraft, wind.norm());
  if (length <= 0.0) return std::nullopt;
  Approach approach;
  approach.heading = HeadingOf(-wind);
  approach.touchdown_in_world = {place.x(), place.y(), map.elevation(row, col)};
  approach.approach_distance = length;
  approach.approach_height = scenario.aircraft.approach_height_m;
  const Eigen::Vector2d start = place - length * DirectionOf(approach.heading);
  approach.approach_start_in_world = {
      start.x(), start.y(), map.elevation(row, col) + approach.approach_height};
  const double airspeed = scenario.aircraft.landing_airspeed_mps *
                          std::cos(RadFromDeg(scenario.aircraft.flight_path_angle_deg));
  approach.ground_speed = airspeed - wind.norm();
  site.plan.touchdown_in_world = approach.touchdown_in_world;
  site.plan.approach = approach;
  return site;
}

// Whether final and roll were seen over the width of the path.
bool IsSeen(const Approach& approach, const Aircraft& aircraft, const EngineRun& run) {
  const Grid& grid = run.evaluation.map.grid;
  const Eigen::Vector2d forward = DirectionOf(approach.heading), right(forward.y(), -forward.x());
  const double begin = -approach.approach_distance, end = aircraft.ground_roll_m;
  for (double along = begin; along <= end; along += grid.cell_size_m) {
    for (double across = -aircraft.path_half_width_m; across <= aircraft.path_half_width_m;
         across += grid.cell_size_m) {
      const auto cell =
          grid.CellAt(approach.touchdown_in_world.head<2>() + along * forward + across * right);
      if (!cell || run.evaluation.hazards.hazard(*cell) == kUnseen) return false;
    }
  }
  return true;
}

struct RiskBin {
  int64_t num = 0;
  double expected = 0.0;
  double observed = 0.0;
  double observed_thin = 0.0;
};
using RiskBins = std::array<RiskBin, kRiskEdges.size()>;

RiskBins BinsOf(const Json& record) {
  RiskBins bins;
  for (const Json& landing : record.at("landing_risks")) {
    RiskBin& bin = bins[BinOf(landing.at(0).get<double>())];
    ++bin.num;
    bin.expected += landing.at(0).get<double>();
    bin.observed += landing.at(1).get<double>();
    bin.observed_thin += landing.at(2).get<double>();
  }
  return bins;
}

// 95 % interval of the observed share of one bin.
std::array<double, 2> Interval(const std::vector<RiskBins>& worlds, size_t bin) {
  constexpr int kNumSamples = 400;
  constexpr uint64_t kSeed = 26;
  std::vector<double> shares;
  for (uint64_t i = 0; i < kNumSamples; ++i) {
    double observed = 0.0, num = 0.0;
    for (uint64_t j = 0; j < worlds.size(); ++j) {
      const auto drawn = static_cast<size_t>(
          Uniform(MixSeed(kSeed, i), j, 0.0, static_cast<double>(worlds.size())));
      const RiskBin& one = worlds[std::min(drawn, worlds.size() - 1)][bin];
      observed += one.observed;
      num += static_cast<double>(one.num);
    }
    if (num > 0.0) shares.push_back(observed / num);
  }
  if (shares.empty()) return {0.0, 1.0};
  std::sort(shares.begin(), shares.end());
  const auto at = [&](double share) {
    return shares[static_cast<size_t>(share * static_cast<double>(shares.size() - 1))];
  };
  return {at(0.025), at(0.975)};
}

}  // namespace

double LogLoss(double expected, double observed) {
  constexpr double kLeast = 1e-4;
  const double risk = std::clamp(expected, kLeast, 1.0 - kLeast);
  return -observed * std::log(risk) - (1.0 - observed) * std::log(1.0 - risk);
}

std::optional<LandingRisk> RiskAt(const Site& site,
                                  const EngineRun& run,
                                  const Aircraft& aircraft,
                                  const ApproachOptions& options) {
  const ElevationMap& map = run.evaluation.map;
  const Approach& approach = *site.plan.approach;
  if (map.elevation.empty() || !IsSeen(approach, aircraft, run)) return std::nullopt;
  const auto cell = map.grid.CellAt(approach.touchdown_in_world.head<2>());
  Approach on_map = approach;
  on_map.touchdown_in_world.z() = map.elevation(*cell);
  const double position_sd_m = std::max(map.position_sd_m, options.min_map_position_sd_m);
  return RiskAssessor(map, run.evaluation.hazards, aircraft, options.risk)
      .Assess(LandingOf(on_map, site, position_sd_m));
}

std::vector<DrawnLanding> DrawLandings(const EngineRun& run,
                                       const Scenario& scenario,
                                       const TruthMap& truth,
                                       const ApproachOptions& options,
                                       uint64_t seed) {
  const ElevationMap& map = run.evaluation.map;
  if (map.elevation.empty()) return {};
  const Aircraft& aircraft = scenario.aircraft;
  const RiskAssessor assessor(map, run.evaluation.hazards, aircraft, options.risk);
  const double position_sd_m = std::max(map.position_sd_m, options.min_map_position_sd_m);
  std::array<int, kRiskEdges.size()> num_in_bin{};
  std::vector<DrawnLanding> landings;
  for (uint64_t i = 0; i < kNumDrawn; ++i) {
    const uint64_t series = MixSeed(seed, i);
    const std::optional<Site> site = DrawnSite(run, scenario, series);
    if (!site || !IsSeen(*site->plan.approach, aircraft, run)) continue;
    const PlannedLanding landing = LandingOf(*site->plan.approach, *site, position_sd_m);
    if (num_in_bin[BinOf(assessor.FailureProbability(landing))]++ >= kMostInBin) {
      continue;
    }
    const FlownSite flown = FlySite(scenario.world, truth, aircraft, *site, series);
    const auto share = [&](int count) { return static_cast<double>(count) / flown.num_flown; };
    landings.push_back(
        {*site, assessor.Assess(landing), share(flown.num_failed), share(flown.num_failed_thin)});
  }
  return landings;
}

Json LandingRisksJson(const EngineRun& run,
                      const Scenario& scenario,
                      const TruthMap& truth,
                      const ApproachOptions& options,
                      uint64_t seed) {
  Json landings = Json::array();
  for (const DrawnLanding& landing : DrawLandings(run, scenario, truth, options, seed)) {
    landings.push_back({landing.risk.failure_probability, landing.observed, landing.observed_thin});
  }
  return landings;
}

Json LandingRiskTotals(const Json& records) {
  std::vector<RiskBins> worlds;
  for (const Json& record : records) {
    if (record.contains("landing_risks")) worlds.push_back(BinsOf(record));
  }
  Json bins = Json::object();
  for (size_t i = 0; i < kRiskEdges.size(); ++i) {
    RiskBin sum;
    for (const RiskBins& world : worlds) {
      sum.num += world[i].num;
      sum.expected += world[i].expected;
      sum.observed += world[i].observed;
      sum.observed_thin += world[i].observed_thin;
    }
    if (sum.num == 0) continue;
    const std::array<double, 2> interval = Interval(worlds, i);
    const auto num = static_cast<double>(sum.num);
    bins[NameOfBin(kRiskEdges[i])] = {{"num_landings", sum.num},
                                      {"expected", RoundedNumber(sum.expected / num)},
                                      {"observed", RoundedNumber(sum.observed / num)},
                                      {"observed_low_95", RoundedNumber(interval[0])},
                                      {"observed_high_95", RoundedNumber(interval[1])},
                                      {"observed_thin", RoundedNumber(sum.observed_thin / num)}};
  }
  return bins;
}

}  // namespace freelsd
