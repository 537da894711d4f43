// Sums that can be added up over worlds, and what they come to.
#pragma once

#include <cstdint>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace freelsd {

struct Sums {
  int64_t count = 0;
  double sum = 0.0;
  double sum_of_squares = 0.0;

  void Add(double value);
  void Add(const Sums& other);
  double Mean() const;
  double Rms() const;
  double Sd() const;
};

// Counts of values on a logarithmic scale: percentiles within 5 %, whatever is added up.
class LogHistogram {
 public:
  void Add(double value);
  void Add(const LogHistogram& other);
  // NaN while empty.
  double Percentile(double percent) const;
  nlohmann::json ToJson() const;
  static LogHistogram FromJson(const nlohmann::json& json);

 private:
  static constexpr int kNumBins = 512;
  std::vector<int64_t> counts_ = std::vector<int64_t>(kNumBins, 0);
};

// Counts of sizes in bins of 5 mm up to 5 m: percentiles within a bin, whatever is added up.
class FineHistogram {
 public:
  // Larger ones count as kLargest.
  void Add(double value);
  void Add(const FineHistogram& other);
  int64_t count() const;
  // NaN while empty. Even within a bin.
  double Percentile(double percent) const;
  nlohmann::json ToJson() const;
  static FineHistogram FromJson(const nlohmann::json& json);

  static constexpr double kBin = 0.005;
  static constexpr double kLargest = 5.0;

 private:
  static constexpr int kNumBins = 1000;
  std::vector<int64_t> counts_ = std::vector<int64_t>(kNumBins, 0);
};

// How often a binary class was given each probability.
struct RocCounts {
  static constexpr int kNumBins = 51;
  std::vector<int64_t> num_true = std::vector<int64_t>(kNumBins, 0);
  std::vector<int64_t> num_false = std::vector<int64_t>(kNumBins, 0);

  void Add(double probability, bool is_true);
  void Add(const RocCounts& other);
  double Auc() const;
  // Expected calibration error: mean difference between the probability of a bin and the share that
  // is true of it.
  double CalibrationError() const;
  // Share that a threshold at 0.5 gets wrong.
  double ErrorRatio() const;
};

nlohmann::json ToJson(const Sums& sums);
Sums SumsFromJson(const nlohmann::json& json);
nlohmann::json ToJson(const RocCounts& counts);
RocCounts RocFromJson(const nlohmann::json& json);

// Upper 95 % bound of a rate of which `num_seen` of `num_tried` were seen (Clopper-Pearson): 0 of
// 600 is 0.5 %.
double UpperBound95(int64_t num_seen, int64_t num_tried);

// Four significant digits; null where there was nothing.
nlohmann::json RoundedNumber(double value);
nlohmann::json RoundedShare(int64_t part, int64_t whole);

}  // namespace freelsd
