#include "tests/bench/contest.h"

#include <algorithm>
#include <chrono>
#include <ctime>

namespace freelsd {
namespace {

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Times of the runs of one side.
class Stopwatch {
 public:
  explicit Stopwatch(double num_units) : num_units_(num_units) {}

  void Run(const std::function<void()>& task) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t worked = std::clock();
    task();
    const double ticks = static_cast<double>(std::clock() - worked);
    const std::chrono::duration<double, std::milli> passed =
        std::chrono::steady_clock::now() - start;
    wall_ms_.push_back(passed.count() / num_units_);
    processor_ms_.push_back(1e3 * ticks / CLOCKS_PER_SEC / num_units_);
  }
  Times Medians() const { return {Median(wall_ms_), Median(processor_ms_)}; }

 private:
  double num_units_;
  std::vector<double> wall_ms_;
  std::vector<double> processor_ms_;
};

volatile double consumed = 0.0;

}  // namespace

void Consume(double value) { consumed = value; }

Row Measure(const Contest& contest, int num_runs, int threads) {
  contest.engine();
  if (contest.plain) contest.plain();
  Stopwatch engine(contest.num_units), plain(contest.num_units);
  for (int run = 0; run < num_runs; ++run) {
    engine.Run(contest.engine);
    if (contest.plain) plain.Run(contest.plain);
  }
  return {contest.name,
          contest.size,
          threads,
          engine.Medians(),
          contest.baseline,
          plain.Medians(),
          contest.note};
}

}  // namespace freelsd
