// How steps of an evaluation are timed, and shared between the processors.
#pragma once

#include <chrono>
#include <functional>
#include <vector>

#include <opencv2/core/utility.hpp>

#include "engine/flight/flight.h"

namespace freelsd {

// Adds the duration of a step to the reports and returns the step's result. Time is only reported:
// no result depends on it.
template <typename Step>
auto Timed(std::vector<StageReport>& reports, const char* stage, Step step) {
  const auto start = std::chrono::steady_clock::now();
  auto answer = step();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  reports.push_back({stage, elapsed.count(), 1, ""});
  return answer;
}

// Calls work(i) for each i below `count`, as many at once as there are threads.
inline void ForEachAtOnce(size_t count, const std::function<void(size_t i)>& work) {
  cv::parallel_for_({0, static_cast<int>(count)}, [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) work(static_cast<size_t>(i));
  });
}

}  // namespace freelsd
