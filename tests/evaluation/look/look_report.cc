#include "tests/evaluation/look/look_report.h"

#include <algorithm>
#include <random>
#include <sstream>
#include <vector>

namespace freelsd {
namespace {

using Json = nlohmann::json;

constexpr double kGoodPercentile = 75.0;

double ValueOf(const Json& outcome) { return outcome.at("landing_value").get<double>(); }

double MeanOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

// Of sorted values, between neighbours.
double PercentileOf(const std::vector<double>& sorted, double percent) {
  const double place = percent / 100.0 * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<size_t>(place);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

// {mean, low, high}: 95 % interval, worlds drawn anew with replacement.
Json WithInterval(const std::vector<double>& values) {
  constexpr int kNumDraws = 4000;
  constexpr uint64_t kDrawSeed = 603;
  if (values.empty()) return {{"mean", nullptr}, {"low", nullptr}, {"high", nullptr}};
  std::mt19937_64 random(kDrawSeed);
  std::vector<double> means;
  for (int i = 0; i < kNumDraws; ++i) {
    double sum = 0.0;
    for (size_t j = 0; j < values.size(); ++j) sum += values[random() % values.size()];
    means.push_back(sum / static_cast<double>(values.size()));
  }
  std::sort(means.begin(), means.end());
  return {{"mean", MeanOf(values)},
          {"low", PercentileOf(means, 2.5)},
          {"high", PercentileOf(means, 97.5)}};
}

int FalseSafeOf(const Json& outcome, const char* key) { return outcome.at(key).get<int>(); }

// Over the worlds.
std::vector<double> Column(const Json& gains, const char* key) {
  std::vector<double> column;
  for (const Json& each : gains) column.push_back(each.at(key).get<double>());
  return column;
}

}  // namespace

Json LookGains(const Json& record) {
  const double before = ValueOf(record.at("before"));
  const double suggested = ValueOf(record.at("suggested")) - before;
  std::vector<double> random;
  double num_beaten = 0.0;
  for (const Json& outcome : record.at("random")) {
    random.push_back(ValueOf(outcome) - before);
    num_beaten += random.back() < suggested ? 1.0 : random.back() == suggested ? 0.5 : 0.0;
  }
  std::sort(random.begin(), random.end());
  const double mean = MeanOf(random);
  const double percentile = 100.0 * num_beaten / static_cast<double>(random.size());
  return {{"seed", record.at("seed")},
          {"aircraft", record.at("aircraft")},
          {"before", before},
          {"expected", record.at("suggested").at("expected_gain")},
          {"suggested", suggested},
          {"random_mean", mean},
          {"random_75", PercentileOf(random, kGoodPercentile)},
          {"random_best", random.back()},
          {"advantage", suggested - mean},
          {"percentile", percentile}};
}

Json LookReport(const Json& settings, const Json& records) {
  Json gains = Json::array();
  int num_good = 0, num_false_safe = 0, num_only_thin = 0, num_random_false_safe = 0;
  for (const Json& record : records) {
    gains.push_back(LookGains(record));
    num_good += gains.back().at("suggested") >= gains.back().at("random_75");
    num_false_safe += FalseSafeOf(record.at("suggested"), "num_false_safe");
    num_only_thin += FalseSafeOf(record.at("suggested"), "num_only_thin");
    for (const Json& outcome : record.at("random")) {
      num_random_false_safe += FalseSafeOf(outcome, "num_false_safe");
    }
  }
  Json totals{{"num_worlds", records.size()},
              {"num_worlds_at_75", num_good},
              {"num_false_safe", num_false_safe},
              {"num_only_thin", num_only_thin},
              {"num_random_false_safe", num_random_false_safe}};
  for (const char* const key :
       {"before", "expected", "suggested", "random_mean", "random_75", "advantage", "percentile"}) {
    totals[key] = WithInterval(Column(gains, key));
  }
  return {{"settings", settings}, {"totals", totals}, {"gains", gains}, {"worlds", records}};
}

std::string LookTable(const Json& report) {
  std::ostringstream table;
  table.precision(3);
  table << "| seed | aircraft | before | expected | suggested | random | 75th | best | "
           "percentile |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const Json& each : report.at("gains")) {
    table << "| " << each.at("seed") << " | " << each.at("aircraft").get<std::string>();
    for (const char* const key : {"before",
                                  "expected",
                                  "suggested",
                                  "random_mean",
                                  "random_75",
                                  "random_best",
                                  "percentile"}) {
      table << " | " << each.at(key).get<double>();
    }
    table << " |\n";
  }
  const Json& totals = report.at("totals");
  table << "\n| mean over worlds | value | 95 % |\n|---|---|---|\n";
  for (const char* const key :
       {"before", "expected", "suggested", "random_mean", "random_75", "advantage", "percentile"}) {
    const Json& of = totals.at(key);
    if (of.at("mean").is_null()) continue;
    table << "| " << key << " | " << of.at("mean").get<double>() << " | "
          << of.at("low").get<double>() << " to " << of.at("high").get<double>() << " |\n";
  }
  table << "\nworlds at or above the 75th percentile: " << totals.at("num_worlds_at_75") << " of "
        << totals.at("num_worlds")
        << "; false safe after the suggested legs: " << totals.at("num_false_safe")
        << ", by thin things alone " << totals.at("num_only_thin")
        << "; after random ones: " << totals.at("num_random_false_safe") << "\n";
  return table.str();
}

}  // namespace freelsd
