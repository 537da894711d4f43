#include "tests/evaluation/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <nlohmann/json.hpp>

namespace freelsd {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
// First bin of the histogram and the ratio of one bin to the next.
constexpr double kFirst = 1e-4;
constexpr double kRatio = 1.05;

// Probability of at most `num_seen` of `num_tried` at that rate.
double AtMost(int64_t num_seen, int64_t num_tried, double rate) {
  double probability = 0.0;
  const double n = static_cast<double>(num_tried);
  for (int64_t k = 0; k <= num_seen; ++k) {
    const double x = static_cast<double>(k);
    const double log_choose =
        std::lgamma(n + 1.0) - std::lgamma(x + 1.0) - std::lgamma(n - x + 1.0);
    probability += std::exp(log_choose + x * std::log(rate) + (n - x) * std::log1p(-rate));
  }
  return probability;
}

void AddUp(std::vector<int64_t>& counts, const std::vector<int64_t>& others) {
  for (size_t i = 0; i < counts.size() && i < others.size(); ++i) counts[i] += others[i];
}

// Pairs of bin and count, without the empty bins.
nlohmann::json SparseJson(const std::vector<int64_t>& counts) {
  nlohmann::json json = nlohmann::json::array();
  for (size_t bin = 0; bin < counts.size(); ++bin) {
    if (counts[bin] > 0) json.push_back({bin, counts[bin]});
  }
  return json;
}

void ReadSparse(std::vector<int64_t>& counts, const nlohmann::json& json) {
  for (const auto& entry : json) {
    counts.at(entry.at(0).get<size_t>()) = entry.at(1).get<int64_t>();
  }
}

}  // namespace

void Sums::Add(double value) {
  if (!std::isfinite(value)) return;
  ++count;
  sum += value;
  sum_of_squares += value * value;
}

void Sums::Add(const Sums& other) {
  count += other.count;
  sum += other.sum;
  sum_of_squares += other.sum_of_squares;
}

double Sums::Mean() const { return count == 0 ? kNan : sum / static_cast<double>(count); }

double Sums::Rms() const {
  return count == 0 ? kNan : std::sqrt(sum_of_squares / static_cast<double>(count));
}

double Sums::Sd() const {
  if (count < 2) return kNan;
  const double n = static_cast<double>(count);
  return std::sqrt(std::max(0.0, (sum_of_squares - sum * sum / n) / (n - 1.0)));
}

void LogHistogram::Add(double value) {
  if (!std::isfinite(value)) return;
  const double bin = std::log(std::max(value, kFirst) / kFirst) / std::log(kRatio);
  ++counts_[static_cast<size_t>(std::clamp(bin, 0.0, kNumBins - 1.0))];
}

void LogHistogram::Add(const LogHistogram& other) { AddUp(counts_, other.counts_); }

double LogHistogram::Percentile(double percent) const {
  int64_t total = 0;
  for (const int64_t count : counts_) total += count;
  int64_t so_far = 0;
  for (size_t bin = 0; bin < counts_.size(); ++bin) {
    so_far += counts_[bin];
    if (so_far > 0 && static_cast<double>(so_far) >= 0.01 * percent * static_cast<double>(total)) {
      return kFirst * std::pow(kRatio, static_cast<double>(bin) + 0.5);
    }
  }
  return kNan;
}

nlohmann::json LogHistogram::ToJson() const { return SparseJson(counts_); }

LogHistogram LogHistogram::FromJson(const nlohmann::json& json) {
  LogHistogram histogram;
  ReadSparse(histogram.counts_, json);
  return histogram;
}

void FineHistogram::Add(double value) {
  if (!std::isfinite(value)) return;
  ++counts_[static_cast<size_t>(std::clamp(value / kBin, 0.0, kNumBins - 1.0))];
}

void FineHistogram::Add(const FineHistogram& other) { AddUp(counts_, other.counts_); }

int64_t FineHistogram::count() const {
  return std::accumulate(counts_.begin(), counts_.end(), int64_t{0});
}

double FineHistogram::Percentile(double percent) const {
  const double wanted = 0.01 * percent * static_cast<double>(count());
  double so_far = 0.0;
  for (size_t bin = 0; bin < counts_.size(); ++bin) {
    const auto in_bin = static_cast<double>(counts_[bin]);
    if (in_bin > 0.0 && so_far + in_bin >= wanted) {
      return kBin * (static_cast<double>(bin) + std::max(0.0, wanted - so_far) / in_bin);
    }
    so_far += in_bin;
  }
  return kNan;
}

nlohmann::json FineHistogram::ToJson() const { return SparseJson(counts_); }

FineHistogram FineHistogram::FromJson(const nlohmann::json& json) {
  FineHistogram histogram;
  ReadSparse(histogram.counts_, json);
  return histogram;
}

void RocCounts::Add(double probability, bool is_true) {
  const double bin = std::floor(std::clamp(probability, 0.0, 1.0) * (kNumBins - 1) + 0.5);
  ++(is_true ? num_true : num_false)[static_cast<size_t>(bin)];
}

void RocCounts::Add(const RocCounts& other) {
  AddUp(num_true, other.num_true);
  AddUp(num_false, other.num_false);
}

double RocCounts::Auc() const {
  double area = 0.0, so_far = 0.0, total_true = 0.0, total_false = 0.0;
  for (size_t bin = 0; bin < num_true.size(); ++bin) {
    const double positives = static_cast<double>(num_true[bin]);
    const double negatives = static_cast<double>(num_false[bin]);
    area += positives * (so_far + 0.5 * negatives);
    so_far += negatives;
    total_true += positives;
    total_false += negatives;
  }
  return total_true * total_false > 0.0 ? area / (total_true * total_false) : kNan;
}

double RocCounts::CalibrationError() const {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < kNumBins; ++i) {
    const auto in_bin = static_cast<double>(num_true[i] + num_false[i]);
    const double probability = static_cast<double>(i) / (kNumBins - 1);
    sum += std::abs(probability * in_bin - static_cast<double>(num_true[i]));
    count += in_bin;
  }
  return sum / count;
}

double RocCounts::ErrorRatio() const {
  int64_t num_wrong = 0, total = 0;
  for (size_t bin = 0; bin < num_true.size(); ++bin) {
    const bool says_true = 2 * static_cast<int>(bin) >= kNumBins - 1;
    num_wrong += says_true ? num_false[bin] : num_true[bin];
    total += num_true[bin] + num_false[bin];
  }
  return total == 0 ? kNan : static_cast<double>(num_wrong) / static_cast<double>(total);
}

nlohmann::json ToJson(const Sums& sums) {
  return nlohmann::json::array({sums.count, sums.sum, sums.sum_of_squares});
}

Sums SumsFromJson(const nlohmann::json& json) {
  return {json.at(0).get<int64_t>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

nlohmann::json ToJson(const RocCounts& counts) {
  return {{"true", counts.num_true}, {"false", counts.num_false}};
}

RocCounts RocFromJson(const nlohmann::json& json) {
  RocCounts counts;
  counts.num_true = json.at("true").get<std::vector<int64_t>>();
  counts.num_false = json.at("false").get<std::vector<int64_t>>();
  counts.num_true.resize(RocCounts::kNumBins);
  counts.num_false.resize(RocCounts::kNumBins);
  return counts;
}

double UpperBound95(int64_t num_seen, int64_t num_tried) {
  if (num_tried <= 0 || num_seen >= num_tried) return 1.0;
  constexpr double kTail = 0.05;
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double rate = 0.5 * (low + high);
    (AtMost(num_seen, num_tried, rate) > kTail ? low : high) = rate;
  }
  return high;
}

nlohmann::json RoundedNumber(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0.0) return 0.0;
  const double scale = std::pow(10.0, 3.0 - std::floor(std::log10(std::abs(value))));
  return std::round(value * scale) / scale;
}

nlohmann::json RoundedShare(int64_t part, int64_t whole) {
  if (whole == 0) return nullptr;
  return RoundedNumber(static_cast<double>(part) / static_cast<double>(whole));
}

}  // namespace freelsd
