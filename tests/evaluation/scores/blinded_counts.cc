#include "tests/evaluation/scores/blinded_counts.h"

#include <cmath>
#include <map>
#include <string>

#include "tests/evaluation/scores/flown_site.h"
#include "tests/evaluation/site_score.h"
#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;
using Counts = std::map<std::string, int64_t>;

void CountFlights(Counts& counts, const FlownSite& flown) {
  counts["num_flown"] += flown.num_flown;
  counts["num_failed"] += flown.num_failed;
  counts["num_failed_absolute"] += flown.absolute.num_failed;
  counts["num_missed_absolute"] += flown.absolute.num_short + flown.absolute.num_long;
}

Counts CountSites(const Scenario& scenario,
                  const TruthMap& truth,
                  const EngineRun& run,
                  uint64_t seed) {
  Counts counts;
  for (const char* name : {"num_accepted",
                           "num_false_safe",
                           "num_only_thin",
                           "num_flown",
                           "num_failed",
                           "num_failed_absolute",
                           "num_missed_absolute"}) {
    counts[name] = 0;
  }
  for (size_t i = 0; i < run.evaluation.sites.size(); ++i) {
    const Site& site = run.evaluation.sites[i];
    const Verdict verdict = site.plan.verdict;
    if (verdict == Verdict::kRejected) continue;
    const auto score =
        ScorePlan(scenario.world, truth, scenario.aircraft, site.plan, Eigen::Vector2d::Zero());
    if (score->IsInDoubt(verdict)) continue;
    ++counts["num_accepted"];
    counts["num_only_thin"] += score->IsOnlyThin(verdict);
    counts["num_false_safe"] += score->IsFalseSafe(verdict) && !score->IsOnlyThin(verdict);
    CountFlights(counts, FlySite(scenario.world, truth, scenario.aircraft, site, MixSeed(seed, i)));
  }
  return counts;
}

Json Share(int64_t part, int64_t whole) {
  if (whole == 0) return nullptr;
  return std::round(1e4 * static_cast<double>(part) / static_cast<double>(whole)) / 1e4;
}

}  // namespace

Json CountBlinded(const Scenario& scenario,
                  const TruthMap& truth,
                  const Fields& fields,
                  const EngineRun& run,
                  const ApproachOptions& options,
                  uint64_t seed) {
  Json json = Json::object();
  for (const std::string& name : BlindingNames()) {
    const EngineRun blinded =
        RunBlinded(scenario, truth, fields, run, *BlindingNamed(name), options);
    json[name] = CountSites(scenario, truth, blinded, seed);
  }
  return json;
}

Json BlindedTotals(const Json& records) {
  std::map<std::string, Counts> totals;
  for (const Json& record : records) {
    if (!record.contains("blinded")) continue;
    for (const auto& [name, counts] : record.at("blinded").items()) {
      for (const auto& [key, count] : counts.items()) totals[name][key] += count.get<int64_t>();
    }
  }
  Json json = Json::object();
  for (const auto& [name, counts] : totals) {
    json[name] = counts;
    const int64_t num_flown = counts.at("num_flown");
    json[name]["failure_ratio"] = Share(counts.at("num_failed"), num_flown);
    json[name]["absolute_failure_ratio"] = Share(counts.at("num_failed_absolute"), num_flown);
    json[name]["absolute_missed_ratio"] = Share(counts.at("num_missed_absolute"), num_flown);
  }
  return json;
}

}  // namespace freelsd
