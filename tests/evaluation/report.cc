#include "tests/evaluation/report.h"

#include <array>
#include <cmath>
#include <map>
#include <sstream>

#include "tests/evaluation/ablation/ablation.h"
#include "tests/evaluation/heights/height_totals.h"
#include "tests/evaluation/scores/blinded_counts.h"
#include "tests/evaluation/scores/landing_risks.h"
#include "tests/evaluation/scores/score_totals.h"
#include "tests/evaluation/statistics.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;
using Counts = std::map<std::string, int64_t>;

Sums AddUp(const Json& records, const char* part, const char* key) {
  Sums sums;
  for (const Json& record : records) sums.Add(SumsFromJson(record.at(part).at(key)));
  return sums;
}

int64_t AddUpCount(const Json& records, const char* part, const char* key) {
  int64_t total = 0;
  for (const Json& record : records) total += record.at(part).at(key).get<int64_t>();
  return total;
}

std::map<std::string, std::array<int64_t, 3>> AddUpTriples(const Json& records,
                                                           const char* part,
                                                           const char* key) {
  std::map<std::string, std::array<int64_t, 3>> total;
  for (const Json& record : records) {
    for (const auto& [name, counts] : record.at(part).at(key).items()) {
      for (size_t i = 0; i < 3; ++i) total[name][i] += counts.at(i).get<int64_t>();
    }
  }
  return total;
}

// Sites by verdict and what was wrong with them.
struct SiteCounts {
  Counts verdicts, reasons, false_safe_causes, thin_causes;
  // By what the ground at the touchdown truly is: accepted, rejected.
  std::map<std::string, std::array<int64_t, 2>> grounds;
  int64_t num_false_safe = 0, num_false_safe_without_shift = 0, num_only_thin = 0;
  int64_t num_in_doubt = 0;
};

std::string CauseOf(const Json& site) {
  std::string cause;
  for (const char* place : {"ground", "final", "loiter"}) {
    const std::string fault = site.value(std::string(place) + "_fault", "");
    if (fault.empty()) continue;
    if (std::string(place) == "loiter" && site.at("verdict") != "landable") continue;
    cause += (cause.empty() ? "" : ", ") + std::string(place) + ": " + fault;
  }
  return cause;
}

SiteCounts CountSites(const Json& records) {
  SiteCounts counts;
  for (const Json& record : records) {
    for (const Json& site : record.at("sites")) {
      ++counts.verdicts[site.at("verdict").get<std::string>()];
      if (site.at("verdict") == "rejected") ++counts.reasons[site.at("reason").get<std::string>()];
      ++counts.grounds[site.at("ground").get<std::string>()][site.at("verdict") == "rejected"];
      if (site.at("is_only_thin").get<bool>()) ++counts.thin_causes[CauseOf(site)];
      counts.num_only_thin += site.at("is_only_thin").get<bool>();
      counts.num_in_doubt += site.value("is_in_doubt", false);
      counts.num_false_safe_without_shift += site.at("is_false_safe_without_shift").get<bool>();
      if (!site.at("is_false_safe").get<bool>()) continue;
      ++counts.num_false_safe;
      ++counts.false_safe_causes[CauseOf(site)];
    }
  }
  return counts;
}

// Fields that the flight could have found, and those that only look like it.
struct FieldCounts {
  int64_t num_true = 0, num_true_seen = 0, num_found = 0, num_blocked = 0, num_blocked_accepted = 0;
  // By a site with nothing wrong, not even what is too thin to be seen.
  int64_t num_found_safely = 0;
  // Of the seen ones: a loiter circle is clear too.
  int64_t num_with_loiter = 0, num_with_loiter_found = 0;
  Counts fates, blocked_fates;
};

bool IsFoundSafely(const Json& record, const Json& field) {
  const Json& sites = record.at("sites");
  return std::any_of(sites.begin(), sites.end(), [&](const Json& site) {
    return site.at("field") == field.at("id") && site.at("verdict") != "rejected" &&
           !site.at("is_false_safe").get<bool>() && !site.at("is_only_thin").get<bool>();
  });
}

FieldCounts CountFields(const Json& records) {
  FieldCounts counts;
  for (const Json& record : records) {
    for (const Json& field : record.at("fields")) {
      const std::string fate = field.at("fate").get<std::string>();
      if (!field.at("is_landable").get<bool>()) {
        ++counts.num_blocked;
        ++counts.blocked_fates[fate];
        counts.num_blocked_accepted += field.at("is_found").get<bool>();
        continue;
      }
      ++counts.num_true;
      if (!field.at("is_seen").get<bool>()) continue;
      ++counts.num_true_seen;
      ++counts.fates[fate];
      counts.num_found += field.at("is_found").get<bool>();
      counts.num_found_safely += IsFoundSafely(record, field);
      if (!field.at("has_loiter").get<bool>()) continue;
      ++counts.num_with_loiter;
      counts.num_with_loiter_found += field.at("is_found").get<bool>();
    }
  }
  return counts;
}

Json SafetyTotals(const Json& records) {
  const SiteCounts sites = CountSites(records);
  const FieldCounts fields = CountFields(records);
  const auto count = [&](const char* verdict) {
    const auto found = sites.verdicts.find(verdict);
    return found == sites.verdicts.end() ? int64_t{0} : found->second;
  };
  const int64_t num_judged = count("landable") + count("unverified") - sites.num_in_doubt;
  Json grounds = Json::object();
  for (const auto& [ground, counted] : sites.grounds) {
    grounds[ground] = {{"num_accepted", counted[0]}, {"num_rejected", counted[1]}};
  }
  Sums seconds;
  for (const Json& record : records) seconds.Add(record.at("total_s").get<double>());
  return {{"num_worlds", records.size()},
          {"num_landable_sites", count("landable")},
          {"num_unverified_sites", count("unverified")},
          {"num_rejected_sites", count("rejected")},
          {"num_false_safe", sites.num_false_safe},
          {"false_safe_bound_95", RoundedNumber(UpperBound95(sites.num_false_safe, num_judged))},
          {"num_false_safe_without_shift", sites.num_false_safe_without_shift},
          {"num_false_safe_thin", sites.num_only_thin},
          {"num_in_doubt", sites.num_in_doubt},
          {"false_safe_causes", sites.false_safe_causes},
          {"thin_causes", sites.thin_causes},
          {"num_fields_in_world", fields.num_true},
          {"num_fields", fields.num_true_seen},
          {"num_fields_found", fields.num_found},
          {"num_fields_found_safely", fields.num_found_safely},
          {"fields_found_ratio", RoundedShare(fields.num_found, fields.num_true_seen)},
          {"num_fields_with_loiter", fields.num_with_loiter},
          {"num_fields_with_loiter_found", fields.num_with_loiter_found},
          {"fates_of_fields", fields.fates},
          {"num_blocked_fields", fields.num_blocked},
          {"num_blocked_fields_accepted", fields.num_blocked_accepted},
          {"fates_of_blocked_fields", fields.blocked_fates},
          {"reject_reasons", sites.reasons},
          {"sites_by_ground", grounds},
          {"time_to_first_site_s", RoundedNumber(seconds.Mean())}};
}

// The main counts alone.
Json SafetyBySpacing(const Json& records) {
  std::map<double, Json> by_spacing;
  for (const Json& record : records) {
    if (!record.contains("spacing_m")) continue;
    Json& of_spacing = by_spacing[record.at("spacing_m").get<double>()];
    of_spacing.push_back(record);
  }
  Json rows = Json::object();
  for (const auto& [spacing_m, of_spacing] : by_spacing) {
    const Json totals = SafetyTotals(of_spacing);
    Json& row = rows[NameOfSpacing(spacing_m)];
    for (const char* key : {"num_worlds", "num_fields", "num_fields_found", "num_false_safe"}) {
      row[key] = totals.at(key);
    }
  }
  return rows;
}

Json MapTotals(const Json& records) {
  Json kinds = Json::object();
  RocCounts grass;
  for (const Json& record : records) {
    grass.Add(RocFromJson(record.at("maps").at("grass_by_views")));
  }
  for (const auto& [kind, counts] : AddUpTriples(records, "maps", "hazard_of_kind")) {
    const int64_t total = counts[0] + counts[1] + counts[2];
    kinds[kind] = {{"num_cells", total},
                   {"free_ratio", RoundedShare(counts[0], total)},
                   {"hazard_ratio", RoundedShare(counts[1], total)},
                   {"unseen_ratio", RoundedShare(counts[2], total)}};
  }
  Sums median;
  for (const Json& record : records) {
    const Json& value = record.at("maps").at("elevation_median_error_m");
    // Not a number where there is no map; null in a file.
    if (value.is_number() && std::isfinite(value.get<double>())) median.Add(value.get<double>());
  }
  Json totals{
      {"elevation_rmse_m", RoundedNumber(AddUp(records, "maps", "elevation_error_m").Rms())},
      {"elevation_rmse_unbiased_m",
       RoundedNumber(AddUp(records, "maps", "elevation_error_unbiased_m").Rms())},
      {"elevation_median_error_m", RoundedNumber(median.Mean())},
      {"slope_rmse_deg", RoundedNumber(AddUp(records, "maps", "slope_error_deg").Rms())},
      {"slope_bias_deg", RoundedNumber(AddUp(records, "maps", "slope_error_deg").Mean())},
      {"roughness_rmse_m", RoundedNumber(AddUp(records, "maps", "roughness_error_m").Rms())},
      {"hazard_recall",
       RoundedShare(AddUpCount(records, "maps", "num_faulty_not_free"),
                    AddUpCount(records, "maps", "num_faulty"))},
      {"hazard_precision",
       RoundedShare(AddUpCount(records, "maps", "num_called_hazard_rightly"),
                    AddUpCount(records, "maps", "num_called_hazard"))},
      {"grass_auc", RoundedNumber(grass.Auc())},
      {"grass_calibration_error", RoundedNumber(grass.CalibrationError())},
      {"grass_by_views", ToJson(grass)},
      {"kinds", kinds}};
  totals.update(DetiltedTotals(records));
  return totals;
}

Json FrontendTotals(const Json& records) {
  Json covers = Json::object();
  for (const auto& [cover, counts] : AddUpTriples(records, "frontend", "pixels_of_cover")) {
    const int64_t total = counts[0] + counts[1] + counts[2];
    covers[cover] = {{"called_grass_ratio", RoundedShare(counts[0], total)},
                     {"called_other_ratio", RoundedShare(counts[1], total)},
                     {"unclassified_ratio", RoundedShare(counts[2], total)}};
  }
  const Sums height = AddUp(records, "frontend", "coarse_height_error_m");
  return {{"coarse_height_rmse_m", RoundedNumber(height.Rms())},
          {"coarse_height_bias_m", RoundedNumber(height.Mean())},
          {"num_regions", AddUpCount(records, "frontend", "num_regions")},
          {"num_graded", AddUpCount(records, "frontend", "num_graded")},
          {"num_duplicates", AddUpCount(records, "frontend", "num_duplicates")},
          {"mean_track_length", RoundedNumber(AddUp(records, "frontend", "track_length").Mean())},
          {"covers", covers}};
}

Json PoseTotals(const Json& records) {
  Sums before, after, shift;
  for (const Json& record : records) {
    const Json& poses = record.at("poses");
    before.Add(poses.at("rms_before_px").get<double>());
    after.Add(poses.at("rms_after_px").get<double>());
    const auto offset = poses.at("shift_m").get<std::array<double, 3>>();
    shift.Add(std::hypot(offset[0], offset[1]));
  }
  const auto rms = [&](const char* key) {
    return RoundedNumber(AddUp(records, "poses", key).Rms());
  };
  return {{"num_views", AddUpCount(records, "poses", "num_views")},
          {"num_connected", AddUpCount(records, "poses", "num_connected")},
          {"horizontal_before_m", rms("horizontal_before_m")},
          {"horizontal_after_m", rms("horizontal_after_m")},
          {"horizontal_shift_m", RoundedNumber(shift.Rms())},
          {"horizontal_within_m", rms("horizontal_within_m")},
          {"vertical_before_m", rms("vertical_before_m")},
          {"vertical_after_m", rms("vertical_after_m")},
          {"attitude_before_deg", rms("attitude_before_deg")},
          {"attitude_after_deg", rms("attitude_after_deg")},
          {"reprojection_before_px", RoundedNumber(before.Mean())},
          {"reprojection_after_px", RoundedNumber(after.Mean())}};
}

// Mean over the worlds of seconds by name, and their sum.
Json SecondsPerWorld(const Json& records, const char* key) {
  std::map<std::string, Sums> parts;
  for (const Json& record : records) {
    if (!record.contains(key)) continue;
    for (const auto& [part, seconds] : record.at(key).items()) {
      parts[part].Add(seconds.get<double>());
      parts["all"].Add(seconds.get<double>());
    }
  }
  Json means = Json::object();
  for (const auto& [part, seconds] : parts) {
    means[part] = RoundedNumber(seconds.sum / static_cast<double>(records.size()));
  }
  return means;
}

// What only runs have that plan.
Json PlanTotals(const Json& records) {
  return {{"safety", SafetyTotals(records)},
          {"safety_by_spacing", SafetyBySpacing(records)},
          {"flown", FlownTotals(records)},
          {"landing_risks", LandingRiskTotals(records)},
          {"found", FoundTotals(records)},
          {"things", ThingTotals(records)},
          {"blinded", BlindedTotals(records)},
          {"ablations", AblationTotals(records)},
          {"frontend", FrontendTotals(records)}};
}

}  // namespace

Json MakeReport(const Json& settings, const Json& records) {
  double peak_mib = 0.0;
  for (const Json& record : records) peak_mib = std::max(peak_mib, record.value("peak_mib", 0.0));
  Json report{{"settings", settings},
              {"cpu_s_per_world", SecondsPerWorld(records, "cpu_s")},
              {"stage_s_per_world", SecondsPerWorld(records, "stage_s")},
              {"maps", MapTotals(records)},
              {"heights", HeightTotals(records)},
              {"poses", PoseTotals(records)},
              {"peak_memory_with_world_mib", RoundedNumber(peak_mib)},
              {"worlds", records}};
  if (!settings.value("heights_only", false)) report.update(PlanTotals(records));
  return report;
}

}  // namespace freelsd
