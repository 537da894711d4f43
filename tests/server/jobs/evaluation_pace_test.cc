#include "server/jobs/evaluation_pace.h"

#include <vector>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr int kPeriod = 10;

// Numbers of frames after which evaluations begin.
std::vector<int> Evaluations(int num_frames, std::optional<int64_t> finish_at, int first_site_at) {
  EvaluationPace pace;
  std::vector<int> begun;
  for (int i = 1; i <= num_frames; ++i) {
    pace.AddFrame();
    const auto left = finish_at ? std::optional<int64_t>(*finish_at - i) : std::nullopt;
    if (!pace.IsDue(kPeriod, left, i > first_site_at)) continue;
    pace.BeginEvaluation();
    begun.push_back(i);
  }
  return begun;
}

TEST_CASE("evaluation pace: in flight, every period") {
  CHECK(Evaluations(45, std::nullopt, 1000) == std::vector<int>{10, 20, 30, 40});
  CHECK(Evaluations(45, std::nullopt, 15) == std::vector<int>{10, 20, 30, 40});
}

TEST_CASE("evaluation pace: where a finish waits, at doubled distances until a site is known") {
  CHECK(Evaluations(170, 1000, 1000) == std::vector<int>{10, 20, 40, 80, 160});
  CHECK(Evaluations(170, 1000, 25) == std::vector<int>{10, 20});
}

TEST_CASE("evaluation pace: nothing begins where the finish is about to") {
  CHECK(Evaluations(49, 49, 1000) == std::vector<int>{10, 20});
  CHECK(Evaluations(9, 9, 1000).empty());
}

}  // namespace
}  // namespace freelsd
