#include "tests/evaluation/scores/score_totals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tests/evaluation/statistics.h"
#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;
using Counts = std::map<std::string, int64_t>;

// Failures of the sites of one world.
struct WorldFailures {
  int64_t num_sites = 0;
  // Sum of the sites' shares of failed flights.
  double sum_of_ratios = 0.0;
};

double MeanOf(const std::vector<WorldFailures>& worlds) {
  WorldFailures all;
  for (const WorldFailures& world : worlds) {
    all.num_sites += world.num_sites;
    all.sum_of_ratios += world.sum_of_ratios;
  }
  return all.sum_of_ratios / static_cast<double>(all.num_sites);
}

// 95 % of the means of as many worlds, drawn with replacement. Draws without a site do not count.
std::array<double, 2> BootstrapInterval(const std::vector<WorldFailures>& worlds) {
  constexpr uint64_t kSeed = 1;
  constexpr size_t kNumDraws = 1000;
  std::vector<double> means;
  means.reserve(kNumDraws);
  uint64_t purpose = 0;
  for (size_t draw = 0; draw < kNumDraws; ++draw) {
    std::vector<WorldFailures> drawn;
    drawn.reserve(worlds.size());
    for (size_t i = 0; i < worlds.size(); ++i) {
      const double place = Uniform(kSeed, ++purpose, 0.0, static_cast<double>(worlds.size()));
      drawn.push_back(worlds[std::min(static_cast<size_t>(place), worlds.size() - 1)]);
    }
    const double mean = MeanOf(drawn);
    if (std::isfinite(mean)) means.push_back(mean);
  }
  std::sort(means.begin(), means.end());
  if (means.empty()) return {std::nan(""), std::nan("")};
  const auto at = [&](double share) {
    return means[static_cast<size_t>(share * static_cast<double>(means.size() - 1))];
  };
  return {at(0.025), at(0.975)};
}

// Shares of the flights of all sites, and counts of sites.
struct FlownCounts {
  Counts totals;
  Counts causes, thin_causes;
  int64_t num_sites = 0;
  int64_t num_failing = 0, num_failing_thin = 0;
  Sums height_bias;
  std::vector<WorldFailures> worlds;
};

void AddCounts(Counts& total, const Json& counts) {
  for (const auto& [name, count] : counts.items()) total[name] += count.get<int64_t>();
}

void AddSite(FlownCounts& counts, const Json& flown) {
  constexpr double kFailingRatio = 0.05;
  ++counts.num_sites;
  for (const char* key : {"num_flown", "num_failed", "num_failed_thin"}) {
    counts.totals[key] += flown.at(key).get<int64_t>();
  }
  for (const auto& [key, count] : flown.at("absolute").items()) {
    counts.totals["absolute_" + key] += count.get<int64_t>();
  }
  AddCounts(counts.causes, flown.at("causes"));
  AddCounts(counts.thin_causes, flown.at("thin_causes"));
  counts.height_bias.Add(flown.at("height_bias_m").get<double>());
  const double num_flown = flown.at("num_flown").get<double>();
  const double ratio = flown.at("num_failed").get<double>() / num_flown;
  counts.num_failing += ratio > kFailingRatio;
  counts.num_failing_thin += flown.at("num_failed_thin").get<double>() / num_flown > kFailingRatio;
  ++counts.worlds.back().num_sites;
  counts.worlds.back().sum_of_ratios += ratio;
}

FlownCounts CountFlown(const Json& records) {
  FlownCounts counts;
  for (const Json& record : records) {
    counts.worlds.emplace_back();
    for (const Json& site : record.at("sites")) {
      if (site.contains("flown")) AddSite(counts, site.at("flown"));
    }
  }
  return counts;
}

// Fields of a class: all, those that the planner accepts on maps without error, those found.
struct FieldClass {
  int64_t num_fields = 0, num_accepted_on_truth = 0, num_found = 0;

  void Add(const Json& field) {
    ++num_fields;
    num_accepted_on_truth += field.at("is_accepted_on_truth").get<bool>();
    num_found += field.at("is_found").get<bool>();
  }
  Json ToJson() const {
    return {{"num_fields", num_fields},
            {"num_accepted_truth", num_accepted_on_truth},
            {"num_found", num_found},
            {"found_ratio", RoundedShare(num_found, num_fields)}};
  }
};

// In alphabetical order, as JSON sorts them.
constexpr std::array<const char*, 3> kRooms{"0-59", "60-149", ">=150"};
constexpr std::array<const char*, 4> kShares{"0-50 %", "50-90 %", "90-100 %", "all"};

size_t RoomOf(const Json& field) {
  const int num_touchdowns = field.at("num_touchdowns").get<int>();
  return num_touchdowns < 60 ? 0 : num_touchdowns < 150 ? 1 : 2;
}

size_t ShareOf(const Json& field) {
  const double share = field.at("photographed_ratio").get<double>();
  return share < 0.5 ? 0 : share < 0.9 ? 1 : share < 1.0 ? 2 : 3;
}

struct FoundCounts {
  FieldClass accepted;
  std::array<FieldClass, kRooms.size()> rooms;
  std::array<FieldClass, kShares.size()> shares;
  Counts reasons_on_truth, reasons_of_lost, false_safe_causes;
  int64_t num_false_safe = 0, num_thin = 0;
};

void AddAccepted(FoundCounts& counts, const Json& field) {
  counts.accepted.Add(field);
  if (!field.at("is_found").get<bool>()) {
    ++counts.reasons_of_lost[field.at("lost_reason").get<std::string>()];
  }
  const std::string fault = field.at("fault_on_truth").get<std::string>();
  if (fault.empty()) return;
  if (field.at("is_only_thin_on_truth").get<bool>()) {
    ++counts.num_thin;
    return;
  }
  ++counts.num_false_safe;
  ++counts.false_safe_causes[fault];
}

void AddField(FoundCounts& counts, const Json& field) {
  const bool is_accepted = field.at("is_accepted_on_truth").get<bool>();
  const bool is_landable = field.at("is_landable").get<bool>();
  if (is_accepted) AddAccepted(counts, field);
  const bool is_seen = is_landable && field.at("is_seen").get<bool>();
  if (is_seen && !is_accepted) {
    ++counts.reasons_on_truth[field.at("reason_on_truth").get<std::string>()];
  }
  if (is_seen || is_accepted) counts.rooms[RoomOf(field)].Add(field);
  if (!is_landable && !is_accepted) return;
  counts.shares[ShareOf(field)].Add(field);
}

template <size_t N>
Json RowsOf(const std::array<const char*, N>& names, const std::array<FieldClass, N>& classes) {
  Json rows = Json::object();
  for (size_t i = 0; i < N; ++i) rows[names[i]] = classes[i].ToJson();
  return rows;
}

}  // namespace

Json FlownTotals(const Json& records) {
  FlownCounts counts = CountFlown(records);
  const std::array<double, 2> interval = BootstrapInterval(counts.worlds);
  const auto share = [&](const char* key) {
    return RoundedShare(counts.totals[key], counts.totals["num_flown"]);
  };
  return {{"num_sites", counts.num_sites},
          {"num_flights", counts.totals["num_flown"]},
          {"failure_ratio", RoundedNumber(MeanOf(counts.worlds))},
          {"failure_ratio_low_95", RoundedNumber(interval[0])},
          {"failure_ratio_high_95", RoundedNumber(interval[1])},
          {"num_sites_above_5_percent", counts.num_failing},
          {"causes", counts.causes},
          {"failure_ratio_thin", share("num_failed_thin")},
          {"num_sites_above_5_percent_thin", counts.num_failing_thin},
          {"thin_causes", counts.thin_causes},
          {"height_bias_rms_m", RoundedNumber(counts.height_bias.Rms())},
          {"absolute_failure_ratio", share("absolute_num_failed")},
          {"absolute_failure_ratio_thin", share("absolute_num_failed_thin")},
          {"absolute_short_ratio", share("absolute_num_short")},
          {"absolute_long_ratio", share("absolute_num_long")}};
}

Json FoundTotals(const Json& records) {
  FoundCounts counts;
  for (const Json& record : records) {
    for (const Json& field : record.at("fields")) {
      if (field.contains("is_accepted_on_truth")) AddField(counts, field);
    }
  }
  const FieldClass& accepted = counts.accepted;
  return {{"fields_accepted_on_truth", accepted.num_fields},
          {"num_found_of_accepted", accepted.num_found},
          {"found_of_accepted_ratio", RoundedShare(accepted.num_found, accepted.num_fields)},
          {"reasons_of_lost_fields", counts.reasons_of_lost},
          {"reasons_on_truth", counts.reasons_on_truth},
          {"num_false_safe_on_truth", counts.num_false_safe},
          {"false_safe_causes_on_truth", counts.false_safe_causes},
          {"num_false_safe_thin_on_truth", counts.num_thin},
          {"by_room", RowsOf(kRooms, counts.rooms)},
          {"by_photographed_ratio", RowsOf(kShares, counts.shares)}};
}

Json ThingTotals(const Json& records) {
  constexpr std::array<const char*, 4> kFates{
      "num_found", "num_unknown", "num_hazard", "num_missed"};
  std::map<std::string, std::array<int64_t, kFates.size()>> totals;
  for (const Json& record : records) {
    if (!record.contains("things")) continue;
    for (const auto& [name, counts] : record.at("things").items()) {
      for (size_t i = 0; i < kFates.size(); ++i) totals[name][i] += counts.at(i).get<int64_t>();
    }
  }
  Json rows = Json::object();
  for (const auto& [name, counts] : totals) {
    for (size_t i = 0; i < kFates.size(); ++i) rows[name][kFates[i]] = counts[i];
  }
  return rows;
}

Json DetiltedTotals(const Json& records) {
  Sums residual, tilt;
  LogHistogram noise;
  for (const Json& record : records) {
    const Json& maps = record.at("maps");
    if (!maps.contains("local_noise_m")) continue;
    residual.Add(SumsFromJson(maps.at("elevation_error_detilted_m")));
    tilt.Add(maps.at("tilt_deg").get<double>());
    noise.Add(LogHistogram::FromJson(maps.at("local_noise_m")));
  }
  return {{"elevation_rmse_detilted_m", RoundedNumber(residual.Rms())},
          {"tilt_rms_deg", RoundedNumber(tilt.Rms())},
          {"local_noise_median_m", RoundedNumber(noise.Percentile(50.0))},
          {"local_noise_p90_m", RoundedNumber(noise.Percentile(90.0))}};
}

}  // namespace freelsd
