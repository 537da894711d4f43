#include "tests/evaluation/heights/height_totals.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace freelsd {
namespace {

using Json = nlohmann::json;

// Of these a mean over worlds would hide the bad ones.
constexpr std::array<const char*, 5> kFiguresOfWorlds{
    "median_m", "p95_m", "beyond_3_sd_ratio", "step_p99_m", "unknown_ratio"};

Json ErrorFigures(const HeightErrors& errors) {
  return {{"num_cells", errors.errors.count},
          {"median_m", RoundedNumber(errors.sizes.Percentile(50.0))},
          {"p95_m", RoundedNumber(errors.sizes.Percentile(95.0))},
          {"rms_m", RoundedNumber(errors.errors.Rms())},
          {"largest_m", RoundedNumber(errors.largest)},
          {"beyond_2_sd_ratio", RoundedShare(errors.num_beyond_2, errors.num_told)},
          {"beyond_3_sd_ratio", RoundedShare(errors.num_beyond_3, errors.num_told)}};
}

Json PlaceFigures(const HeightScores& scores) {
  Json places = Json::object();
  for (const auto& [place, errors] : scores.plane_off) {
    places[place + ", plane off"] = ErrorFigures(errors);
  }
  for (const auto& [place, errors] : scores.shift_off) {
    places[place + ", shift off"] = ErrorFigures(errors);
  }
  return places;
}

std::string NameOfBin(size_t bin) {
  const auto& edges = HeightScores::kToldEdges;
  std::ostringstream name;
  name << std::fixed << std::setprecision(2) << edges[bin] << " to ";
  if (bin + 1 == edges.size()) return name.str() + "inf";
  name << edges[bin + 1];
  return name.str();
}

Json ToldFigures(const HeightScores& scores) {
  Json bins = Json::object();
  for (size_t i = 0; i < scores.by_told.size(); ++i) {
    const ToldDeviations& told = scores.by_told[i];
    bins[NameOfBin(i)] = {{"num_cells", told.told.count},
                          {"told_rms_m", RoundedNumber(told.told.Rms())},
                          {"true_rms_m", RoundedNumber(told.errors.Rms())}};
  }
  return bins;
}

// Median and largest of the worlds.
Json OverWorlds(const std::vector<Json>& figures, const char* key) {
  std::vector<double> values;
  for (const Json& each : figures) {
    if (each.at(key).is_number()) values.push_back(each.at(key).get<double>());
  }
  if (values.empty()) return Json::object();
  std::sort(values.begin(), values.end());
  return {{"median", values[values.size() / 2]}, {"largest", values.back()}};
}

// Without the tables.
Json PlainFigures(const HeightScores& scores) {
  Json figures = HeightFigures(scores);
  figures.erase("by_place");
  figures.erase("by_told_deviation");
  return figures;
}

}  // namespace

Json HeightFigures(const HeightScores& scores) {
  const auto all = scores.plane_off.find("all");
  Json figures = ErrorFigures(all == scores.plane_off.end() ? HeightErrors{} : all->second);
  figures["unknown_ratio"] = RoundedShare(scores.num_unknown, scores.num_open);
  figures["scattered_of_unknown_ratio"] = RoundedShare(scores.num_scattered, scores.num_unknown);
  figures["step_p95_m"] = RoundedNumber(scores.steps.Percentile(95.0));
  figures["step_p99_m"] = RoundedNumber(scores.steps.Percentile(99.0));
  figures["step_far_p99_m"] = RoundedNumber(scores.steps_far.Percentile(99.0));
  figures["landable_looks_rough_ratio"] =
      RoundedShare(scores.num_looking_rough, scores.num_landable);
  figures["landable_rough_hazard_ratio"] =
      RoundedShare(scores.num_rough_hazards, scores.num_landable);
  figures["by_place"] = PlaceFigures(scores);
  figures["by_told_deviation"] = ToldFigures(scores);
  return figures;
}

Json HeightRecord(const HeightScores& scores) {
  return {{"figures", HeightFigures(scores)}, {"counts", ToJson(scores)}};
}

std::string NameOfSpacing(double spacing_m) {
  std::ostringstream name;
  name << std::setw(3) << spacing_m << " m apart";
  return name.str();
}

Json HeightTotals(const Json& records) {
  HeightScores all;
  std::map<double, HeightScores> by_spacing;
  std::vector<Json> of_worlds;
  for (const Json& record : records) {
    if (!record.contains("heights")) continue;
    const HeightScores scores = HeightScoresFromJson(record.at("heights").at("counts"));
    all.Add(scores);
    by_spacing[record.at("spacing_m").get<double>()].Add(scores);
    of_worlds.push_back(record.at("heights").at("figures"));
  }
  if (of_worlds.empty()) return Json::object();
  Json totals = HeightFigures(all);
  for (const char* key : kFiguresOfWorlds) {
    totals["worlds_" + std::string(key)] = OverWorlds(of_worlds, key);
  }
  totals["by_spacing"] = Json::object();
  for (const auto& [spacing_m, scores] : by_spacing) {
    totals["by_spacing"][NameOfSpacing(spacing_m)] = PlainFigures(scores);
  }
  return totals;
}

}  // namespace freelsd
