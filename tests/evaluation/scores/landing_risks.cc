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
#include "tests/evaluation/scores/obstruction.h"
#include "tests/evaluation/statistics.h"
#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

// Bins of the expected risk, two a decade; the first holds everything below.
constexpr std::array<double, 7> kRiskEdges{0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.1};
constexpr std::array<double, 10> kShapeEdges{0.1, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0, 1.5, 1e9};
constexpr int kNumDrawn = 6000;
constexpr int kMostInBin = 40;

template <size_t N>
size_t BinOf(double value, const std::array<double, N>& edges) {
  return static_cast<size_t>(
      std::find_if(edges.begin(), edges.end(), [&](double edge) { return value < edge; }) -
      edges.begin());
}

std::string NameOfBin(double edge) {
  std::ostringstream name;
  name << "below " << std::fixed << std::setprecision(3) << std::min(edge, 9.0);
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

// The risk without what an exactly known position or wind would take off, or without a part.
Json WithoutParts(const LandingRisk& risk) {
  const FailureParts& parts = risk.parts;
  const double all = risk.failure_probability;
  return {parts.final_path, parts.ground, all - parts.position, all - parts.wind};
}

Json LandingsJson(const std::vector<DrawnLanding>& drawn) {
  Json landings = Json::array();
  for (const DrawnLanding& landing : drawn) {
    landings.push_back({landing.risk.failure_probability,
                        landing.observed,
                        landing.observed_thin,
                        WithoutParts(landing.risk),
                        landing.causes});
  }
  return landings;
}

// Ground of another kind is no matter of its shape; thin things are not seen anyway.
bool IsOtherKind(const std::string& fault) {
  constexpr std::array<const char*, 12> kShapeFaults{"",
                                                     "rough",
                                                     "steep",
                                                     "tree",
                                                     "bare tree",
                                                     "hedge",
                                                     "boulder",
                                                     "animal",
                                                     "vehicle",
                                                     "house",
                                                     "bale",
                                                     "ditch"};
  return std::find(kShapeFaults.begin(), kShapeFaults.end(), fault) == kShapeFaults.end();
}

// The map is moved back by its shift first.
Json ShapesJson(const EngineRun& run,
                const Scenario& scenario,
                const TruthMap& truth,
                const Eigen::Vector2d& shift) {
  const ElevationMap& map = run.evaluation.map;
  const HazardLayers& layers = run.evaluation.hazards;
  const Aircraft& aircraft = scenario.aircraft;
  std::array<std::array<int64_t, 2>, kShapeEdges.size()> counts{};
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      const bool is_grass = layers.grass(row, col) >= layers.min_grass_posterior;
      if (!is_grass || layers.hazard(row, col) == kUnseen) continue;
      const Eigen::Vector2d place = map.grid.CellCenter(row, col) - shift;
      if (place.cwiseAbs().maxCoeff() >= 0.5 * scenario.world.size_m) continue;
      const cv::Point cell = truth.CellAt(place);
      if (IsOtherKind(NameOfFault(truth, cell))) continue;
      std::array<int64_t, 2>& bin =
          counts[BinOf(ShapeRatio(map, layers, aircraft, {col, row}), kShapeEdges)];
      ++bin[0];
      bin[1] += truth.fault(cell) != 0;
    }
  }
  return counts;
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
  for (const Json& landing : record.at("landing_risks").at("landings")) {
    RiskBin& bin = bins[BinOf(landing.at(0).get<double>(), kRiskEdges)];
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

// By the part that is left out: the mean log loss of the rest, less that of the whole.
Json LossesWithoutParts(const Json& records) {
  constexpr std::array<const char*, 4> kParts{"ground", "final", "position", "wind"};
  std::array<double, kParts.size()> sums{};
  double num = 0.0;
  for (const Json& record : records) {
    if (!record.contains("landing_risks")) continue;
    for (const Json& landing : record.at("landing_risks").at("landings")) {
      const auto observed = landing.at(1).get<double>();
      const double whole = LogLoss(landing.at(0).get<double>(), observed);
      for (size_t i = 0; i < kParts.size(); ++i) {
        sums[i] += LogLoss(landing.at(3).at(i).get<double>(), observed) - whole;
      }
      ++num;
    }
  }
  Json losses = Json::object();
  for (size_t i = 0; i < kParts.size(); ++i) {
    losses[kParts[i]] = RoundedNumber(sums[i] / std::max(1.0, num));
  }
  return losses;
}

// What fails landings that the engine takes for safe.
Json CausesOfSmallRisks(const Json& records) {
  constexpr double kSmall = 0.1;
  std::map<std::string, int> causes;
  for (const Json& record : records) {
    if (!record.contains("landing_risks")) continue;
    for (const Json& landing : record.at("landing_risks").at("landings")) {
      if (landing.at(0).get<double>() >= kSmall) continue;
      for (const auto& [cause, num] : landing.at(4).items()) causes[cause] += num.get<int>();
    }
  }
  return causes;
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
    if (num_in_bin[BinOf(assessor.FailureProbability(landing), kRiskEdges)]++ >= kMostInBin) {
      continue;
    }
    const FlownSite flown = FlySite(scenario.world, truth, aircraft, *site, series);
    const auto share = [&](int count) { return static_cast<double>(count) / flown.num_flown; };
    landings.push_back({*site,
                        assessor.Assess(landing),
                        share(flown.num_failed),
                        share(flown.num_failed_thin),
                        flown.causes});
  }
  return landings;
}

Json LandingRisksJson(const EngineRun& run,
                      const Scenario& scenario,
                      const TruthMap& truth,
                      const PipelineOptions& options,
                      const DrawnSeries& series) {
  const auto& [seed, shift] = series;
  if (run.evaluation.map.elevation.empty()) {
    return {{"landings", Json::array()}, {"shapes", Json::array()}};
  }
  return {{"landings", LandingsJson(DrawLandings(run, scenario, truth, options.approach, seed))},
          {"shapes", ShapesJson(run, scenario, truth, shift)}};
}

Json LandingRiskTotals(const Json& records) {
  std::vector<RiskBins> worlds;
  std::array<std::array<int64_t, 2>, kShapeEdges.size()> shapes{};
  for (const Json& record : records) {
    if (!record.contains("landing_risks")) continue;
    worlds.push_back(BinsOf(record));
    const Json& counts = record.at("landing_risks").at("shapes");
    for (size_t i = 0; i < counts.size(); ++i) {
      shapes[i][0] += counts.at(i).at(0).get<int64_t>();
      shapes[i][1] += counts.at(i).at(1).get<int64_t>();
    }
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
  Json by_shape = Json::object();
  for (size_t i = 0; i < kShapeEdges.size(); ++i) {
    by_shape[NameOfBin(kShapeEdges[i])] = {
        {"num_cells", shapes[i][0]}, {"unfit_ratio", RoundedShare(shapes[i][1], shapes[i][0])}};
  }
  return {{"risks", bins},
          {"without_part", LossesWithoutParts(records)},
          {"causes_below_0.1", CausesOfSmallRisks(records)},
          {"shapes", by_shape}};
}

}  // namespace freelsd
