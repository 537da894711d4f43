// Flights take turns at the engine.
#include "server/jobs/evaluation_queue.h"

#include <algorithm>
#include <chrono>

#include <doctest/doctest.h>

#include "tests/server/sample_flight.h"

namespace freelsd {
namespace {

TEST_CASE("evaluation queue: a flight that is due again and again comes behind all others") {
  EvaluationQueue queue;
  CHECK_FALSE(queue.Take());
  queue.Add("a");
  queue.Add("c");
  queue.Add("b");
  queue.Add("a");
  CHECK(queue.Take() == "a");
  queue.Add("a");
  CHECK(queue.Take() == "c");
  CHECK(queue.Take() == "b");
  CHECK(queue.Take() == "a");
  CHECK_FALSE(queue.Take());
}

TEST_CASE("evaluation queue: the stream with the smallest id does not starve the others") {
  // Enough to keep the engine busy until the other flight is evaluated.
  constexpr int kNumRounds = 16;
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  const nlohmann::json options{{"backend", {{"backend_period_frames", 1}}}};
  const std::string one = NewSampleFlight(fresh.client, options);
  const std::string other = NewSampleFlight(fresh.client, options);
  const auto [first, second] = std::minmax(one, other);
  for (int round = 0; round < kNumRounds; ++round) {
    PostSampleFrames(fresh.client, first, 0, kNumSampleFrames, std::to_string(round) + "-");
  }
  PostSampleFrames(fresh.client, second, 0, kNumSampleFrames);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(3);
  while (SiteIds(fresh.client, second).empty() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  CHECK_FALSE(SiteIds(fresh.client, second).empty());
  const nlohmann::json frames = GetJson(fresh.client, "/v1/flights/" + first)["frames"];
  CHECK(frames["processed"] < frames["received"]);
  fresh.client.Delete("/v1/flights/" + first);
}

}  // namespace
}  // namespace freelsd
