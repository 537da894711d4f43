// How long work still takes, on work whose duration is known.
#include "server/jobs/time_left.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr double kStepS = 0.3;

// Plays work of `duration_s` whose progress at each time is given, and hands each estimate to
// `look` with the time at which it was made.
void Play(double duration_s,
          const std::function<double(double)>& ratio_at,
          const std::function<void(double, std::optional<double>)>& look,
          std::optional<double> expected_s = std::nullopt) {
  TimeLeft left(0.0, 0.0, expected_s);
  for (double time_s = 0.0; time_s < duration_s; time_s += kStepS) {
    left.Add(time_s, ratio_at(time_s));
    look(time_s, left.At(time_s));
  }
}

// When each of the steps ends: they differ by up to 20 % from their mean.
std::vector<double> EndsOfSteps(double duration_s, int num_steps, std::mt19937& random) {
  std::uniform_real_distribution<double> share(0.8, 1.2);
  std::vector<double> ends;
  ends.reserve(static_cast<size_t>(num_steps));
  double sum = 0.0;
  for (int i = 0; i < num_steps; ++i) ends.push_back(sum += share(random));
  for (double& end : ends) end *= duration_s / sum;
  return ends;
}

TEST_CASE("time left: of steady work it errs by less than 8 % and one step after a fifth") {
  std::mt19937 random(3);
  for (const double duration_s : {30.0, 60.0, 900.0}) {
    for (const int num_steps : {20, 57, 1000}) {
      const std::vector<double> ends = EndsOfSteps(duration_s, num_steps, random);
      const auto ratio_at = [&](double time_s) {
        const auto next = std::upper_bound(ends.begin(), ends.end(), time_s);
        return static_cast<double>(next - ends.begin()) / num_steps;
      };
      double worst_s = 0.0;
      Play(duration_s, ratio_at, [&](double time_s, std::optional<double> left_s) {
        if (time_s < 0.2 * duration_s + 1.0) return;
        REQUIRE(left_s);
        worst_s = std::max(worst_s, std::abs(*left_s - (duration_s - time_s)));
      });
      INFO(duration_s << " s in " << num_steps << " steps, error " << worst_s << " s");
      // A step tells nothing of itself before it is done.
      CHECK(worst_s < 0.08 * duration_s + duration_s / num_steps);
    }
  }
}

// The progress of work with two stages of equal share, the second of which takes much longer.
double SlowerLater(double time_s, double fast_s, double slow_s) {
  if (time_s < fast_s) return 0.5 * time_s / fast_s;
  return 0.5 + 0.5 * (time_s - fast_s) / slow_s;
}

TEST_CASE("time left: of work that is slower later it is never negative and never jumps") {
  for (const double slow_s : {60.0, 120.0, 400.0}) {
    double before_s = NAN;
    double worst_end_error_s = 0.0;
    Play(
        20.0 + slow_s,
        [&](double time_s) { return SlowerLater(time_s, 20.0, slow_s); },
        [&](double time_s, std::optional<double> left_s) {
          if (!left_s) return;
          CHECK(*left_s >= 0.0);
          // The measured slowness grows over seconds, and so does what is shown.
          if (!std::isnan(before_s)) CHECK(std::abs(*left_s - before_s) < 0.1 * before_s + 2.0);
          before_s = *left_s;
          const double truth_s = 20.0 + slow_s - time_s;
          if (time_s > 20.0 + 0.7 * slow_s) {
            worst_end_error_s = std::max(worst_end_error_s, std::abs(*left_s - truth_s));
          }
        });
    INFO(slow_s);
    CHECK(worst_end_error_s < 0.12 * (20.0 + slow_s));
  }
}

TEST_CASE("time left: work that stands still has more and more left, not less") {
  TimeLeft left(0.0, 0.0);
  left.Add(10.0, 0.5);
  const double at_first_s = left.At(10.0).value();
  CHECK(at_first_s == doctest::Approx(10.0));
  double last_s = 0.0;
  for (double time_s = 10.0; time_s < 100.0; time_s += kStepS) {
    last_s = left.At(time_s).value();
    CHECK(last_s > 0.0);
  }
  CHECK(last_s > 2.0 * at_first_s);
}

TEST_CASE(
    "time left: nothing is said before anything was measured, unless it is known from earlier") {
  TimeLeft unknown(100.0, 0.0);
  CHECK_FALSE(unknown.At(100.0));
  CHECK_FALSE(unknown.At(130.0));
  unknown.Add(130.2, 0.01);
  CHECK_FALSE(unknown.At(130.2));
  TimeLeft known(100.0, 0.0, 50.0);
  CHECK(known.At(100.0).value() == doctest::Approx(50.0));
  CHECK(known.At(120.0).value() == doctest::Approx(30.0));
  CHECK(known.At(500.0).value() > 0.0);
}

TEST_CASE("time left: a wrong expectation is forgotten after a fifth of the work") {
  double worst_s = 0.0;
  Play(
      100.0,
      [](double time_s) { return time_s / 100.0; },
      [&](double time_s, std::optional<double> left_s) {
        REQUIRE(left_s);
        if (time_s > 40.0) worst_s = std::max(worst_s, std::abs(*left_s - (100.0 - time_s)));
      },
      600.0);
  CHECK(worst_s < 15.0);
}

TEST_CASE("time left: work that goes on after a restart is measured from there") {
  TimeLeft left(0.0, 0.6);
  left.Add(10.0, 0.8);
  CHECK(left.At(10.0).value() == doctest::Approx(10.0));
  left.Add(20.0, 1.0);
  CHECK(left.At(30.0).value() == doctest::Approx(0.0));
}

TEST_CASE("time left: progress that goes back or is no number changes nothing") {
  TimeLeft left(0.0, 0.0);
  left.Add(10.0, 0.5);
  const double before_s = left.At(10.0).value();
  left.Add(10.0, 0.2);
  left.Add(10.0, NAN);
  left.Add(10.0, -1.0);
  CHECK(left.At(10.0).value() == doctest::Approx(before_s));
  left.Add(20.0, 5.0);
  CHECK(left.At(20.0).value() == doctest::Approx(0.0));
}

}  // namespace
}  // namespace freelsd
