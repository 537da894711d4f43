// Bad clocks and bad links, at random: the live pose and wind must be those of a plain model that
// knows when each sample was taken. FREELSD_MODEL_STEPS: number of steps, 200 by default.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <memory>
#include <random>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/intake/telemetry.h"
#include "server/recall/live_pose/live_pose.h"
#include "tests/storage/place.h"
#include "tests/storage/temporary_folder.h"

namespace freelsd {
namespace {

constexpr int64_t kSecondUs = 1000000;
constexpr int64_t kStartUs = 1700000000 * kSecondUs;
// A pose and a wind say by their values when they were measured.
constexpr double kDegreesPerS = 20.0 / 111195.0;
constexpr double kWindPerS = 1e-3;
constexpr double kMaxTimeErrorS = 0.01;
// Delays of a good link, of which nobody knows how much is the clock's.
constexpr double kMaxAgeErrorS = 2.5;
constexpr int kStepsPerFlight = 100;
constexpr int kNumFirstSeconds = 10;
constexpr int kGoodBetweenOutliers = 3;
// A clock that is behind by more looks like a link that is late, and a sample ahead in it like one
// that came sooner: ages are too old then, and nobody can tell such an outlier.
constexpr double kMaxClockErrorS = 120.0;

struct Sample {
  double taken_s = 0.0;
  double own_s = 0.0;
  bool is_outlier = false;
};

std::vector<TelemetryRow> RowsOf(const Sample& sample, double arrived_s) {
  const nlohmann::json line{
      {"timestamp_us", kStartUs + std::llround(sample.own_s * 1e6)},
      {"position",
       {{"latitude_deg", 47.0 + sample.taken_s * kDegreesPerS},
        {"longitude_deg", 8.0},
        {"altitude_m", 500.0}}},
      {"wind",
       {{"east_mps", sample.taken_s * kWindPerS}, {"north_mps", 0.0}, {"source", "autopilot"}}}};
  std::vector<TelemetryRow> rows = ParseTelemetryLine(line.dump());
  for (TelemetryRow& row : rows) row.arrived_at_us = kStartUs + std::llround(arrived_s * 1e6);
  return rows;
}

// A flight whose data arrive in a database of its own. Times are seconds since its start, on the
// server's clock, which is right.
class ModelFlight {
 public:
  explicit ModelFlight(uint64_t seed) : random_(seed) {
    FlightRow flight;
    flight.id = "f";
    flight.request_json = ParseFlightRequest(R"({"name":"f"})").canonical_json;
    storage_->flights.Insert(flight);
    constexpr double kErrorsS[] = {0.0, 0.5, -0.5, 20.0, -20.0, 90.0, -90.0, 3600.0, -600.0};
    error_s_ = kErrorsS[Below(std::size(kErrorsS))];
    for (int i = 0; i < kNumFirstSeconds; ++i) Fly(0.0);
  }

  double error_s() const { return error_s_; }

  // One random step, and the checks after it. Returns what it was.
  std::string Step() {
    const size_t kind = Below(20);
    if (kind < 3 && num_good_ >= kGoodBetweenOutliers && !IsFarBehind()) return FlyOutlier();
    if (kind < 6) return LoseLink();
    if (kind == 6) return Restart();
    if (kind == 7) return StandStill();
    Fly(0.0);
    Check();
    return "good";
  }

 private:
  bool IsFarBehind() const { return -error_s_ > kMaxClockErrorS; }
  size_t Below(size_t end) { return std::uniform_int_distribution<size_t>(0, end - 1)(random_); }
  double Between(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }

  Sample Take(double jump_s) {
    now_s_ += 1.0;
    num_good_ = jump_s == 0.0 ? num_good_ + 1 : 0;
    return {now_s_, now_s_ + error_s_ + jump_s, jump_s != 0.0};
  }

  void Deliver(const std::vector<Sample>& samples) {
    std::vector<TelemetryRow> rows;
    for (const Sample& sample : samples) {
      const std::vector<TelemetryRow> some = RowsOf(sample, now_s_);
      rows.insert(rows.end(), some.begin(), some.end());
      newest_s_ = std::max(newest_s_, sample.taken_s);
      if (!sample.is_outlier) newest_good_s_ = std::max(newest_good_s_, sample.taken_s);
    }
    REQUIRE(storage_->telemetry.Put("f", rows));
  }

  void Fly(double jump_s) {
    const Sample sample = Take(jump_s);
    now_s_ += Between(0.02, 0.4);
    Deliver({sample});
  }

  std::string FlyOutlier() {
    constexpr double kJumpsS[] = {100.0, 12.0 * 3600.0, 24.0 * 3600.0 - 10.0};
    const double jump_s = kJumpsS[Below(std::size(kJumpsS))];
    // What is more than a day ahead is refused.
    if (error_s_ + jump_s > 24.0 * 3600.0) return "outlier refused";
    Fly(jump_s);
    Check();
    return "outlier of " + std::to_string(std::lround(jump_s)) + " s";
  }

  // The link's backlog comes in portions, the oldest first, and new samples wait behind it.
  std::string LoseLink() {
    const size_t num_lost = 3 + Below(150);
    std::deque<Sample> backlog;
    for (size_t i = 0; i < num_lost; ++i) backlog.push_back(Take(0.0));
    while (!backlog.empty()) {
      const size_t num = std::min(backlog.size(), 2 + Below(40));
      const auto end = backlog.begin() + static_cast<std::ptrdiff_t>(num);
      now_s_ += 0.1;
      Deliver({backlog.begin(), end});
      backlog.erase(backlog.begin(), end);
      Check();
      if (Below(3) == 0 && !backlog.empty()) backlog.push_back(Take(0.0));
    }
    return "outage of " + std::to_string(num_lost) + " s";
  }

  std::string Restart() {
    storage_.reset();
    storage_ = std::make_unique<Storage>(StorageAt(folder_.path()));
    Check();
    return "restart";
  }

  std::string StandStill() {
    now_s_ += Between(1.0, 30.0);
    Check();
    return "silence";
  }

  // The newest of what arrived. One with a wrong time may be taken only if it is.
  void CheckTime(double taken_s) const {
    CAPTURE(newest_good_s_);
    CAPTURE(newest_s_);
    CAPTURE(taken_s);
    const bool is_newest_good = std::abs(taken_s - newest_good_s_) < kMaxTimeErrorS;
    REQUIRE((is_newest_good || std::abs(taken_s - newest_s_) < kMaxTimeErrorS));
  }

  void CheckAge(double taken_s, const std::optional<double>& age_s) const {
    if (std::abs(taken_s - newest_good_s_) > kMaxTimeErrorS) return;
    CAPTURE(now_s_ - taken_s);
    REQUIRE(age_s);
    REQUIRE(*age_s > now_s_ - taken_s - kMaxAgeErrorS);
    const double late_s = IsFarBehind() ? -error_s_ : 0.0;
    REQUIRE(*age_s < now_s_ - taken_s + kMaxAgeErrorS + late_s);
  }

  void Check() const {
    const int64_t now_us = kStartUs + std::llround(now_s_ * 1e6);
    CAPTURE(now_s_);
    const std::optional<LivePose> pose = LivePoseOf(*storage_, "f", now_us);
    REQUIRE(pose);
    const double flown_s = (pose->place.latitude_deg - 47.0) / kDegreesPerS;
    CheckTime(flown_s);
    CheckAge(flown_s, pose->age_s);
    const std::optional<LiveWind> wind = LiveWindOf(*storage_, "f", now_us);
    REQUIRE(wind);
    const double blown_s = wind->wind_in_world.x() / kWindPerS;
    CheckTime(blown_s);
    CheckAge(blown_s, wind->age_s);
  }

  TemporaryFolder folder_;
  std::unique_ptr<Storage> storage_ = std::make_unique<Storage>(StorageAt(folder_.path()));
  std::mt19937_64 random_;
  double error_s_ = 0.0;
  double now_s_ = 0.0;
  double newest_s_ = 0.0;
  double newest_good_s_ = 0.0;
  int num_good_ = 0;
};

int NumSteps() {
  const char* const given = std::getenv("FREELSD_MODEL_STEPS");
  return given != nullptr ? std::stoi(given) : 200;
}

TEST_CASE("live pose and wind: a plain model agrees, whatever clocks and links do") {
  const int num_steps = NumSteps();
  for (int first = 0; first < num_steps; first += kStepsPerFlight) {
    const auto seed = static_cast<uint64_t>(first / kStepsPerFlight);
    ModelFlight flight(seed);
    CAPTURE(seed);
    CAPTURE(flight.error_s());
    std::string steps;
    for (int i = first; i < std::min(first + kStepsPerFlight, num_steps); ++i) {
      INFO("after " << steps);
      const std::string step = flight.Step();
      steps = (steps.size() > 200 ? steps.substr(steps.size() - 200) : steps) + ", " + step;
    }
  }
}

}  // namespace
}  // namespace freelsd
