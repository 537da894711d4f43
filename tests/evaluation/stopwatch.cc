#include "tests/evaluation/stopwatch.h"

#include <ctime>

namespace freelsd {

Stopwatch::Stopwatch(bool counts_process) : counts_process_(counts_process), last_(Now()) {}

void Stopwatch::Lap(const std::string& part) {
  const double now = Now();
  seconds_[part] += now - last_;
  last_ = now;
}

double Stopwatch::Now() const {
  timespec time{};
  clock_gettime(counts_process_ ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace freelsd
