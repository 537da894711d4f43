#include "tests/bench/contest.h"

#include <algorithm>
#include <chrono>

namespace freelsd {
namespace {

double RunMs(const std::function<void()>& task) {
  const auto start = std::chrono::steady_clock::now();
  task();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

volatile double consumed = 0.0;

}  // namespace

void Consume(double value) { consumed = value; }

Row Measure(const Contest& contest, int num_runs, int threads) {
  std::vector<double> engine, plain;
  for (int run = -1; run < num_runs; ++run) {
    const double engine_ms = RunMs(contest.engine) / contest.num_units;
    const double plain_ms = contest.plain ? RunMs(contest.plain) / contest.num_units : 0.0;
    if (run < 0) continue;
    engine.push_back(engine_ms);
    if (contest.plain) plain.push_back(plain_ms);
  }
  return {contest.name, contest.size, threads, Median(engine), contest.baseline, Median(plain)};
}

}  // namespace freelsd
