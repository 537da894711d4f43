#include "server/intake/arrival_clock.h"

#include <algorithm>
#include <vector>

#include <doctest/doctest.h>

#include "server/intake/telemetry.h"
#include "tests/server/test_server.h"

namespace freelsd {
namespace {

constexpr int64_t kSecondUs = 1000000;
constexpr int64_t kNowUs = 1700000000 * kSecondUs;

TEST_CASE("arrival clock: an age is told where the time of arrival is known, and only there") {
  CHECK(AgeS(kNowUs - 5 * kSecondUs, kNowUs) == 5.0);
  // Stored together with others: microseconds ahead.
  CHECK(AgeS(kNowUs + 10, kNowUs) == 0.0);
  // The clock was set back since.
  CHECK_FALSE(AgeS(kNowUs + 3600 * kSecondUs, kNowUs));
  // The clock was not set when it arrived; while it never is, differences still tell.
  CHECK_FALSE(AgeS(100 * kSecondUs, kNowUs));
  CHECK(AgeS(100 * kSecondUs, 107 * kSecondUs) == 7.0);
}

// Own time and time of arrival, in seconds from kNowUs on.
ArrivedSample At(double own_s, double arrived_s) {
  return {kNowUs + static_cast<int64_t>(own_s * 1e6),
          kNowUs + static_cast<int64_t>(arrived_s * 1e6)};
}

// One sample a second, each half a second under way, from a clock that is so much behind.
std::vector<ArrivedSample> Live(int begin_s, int end_s, double behind_s = 0.0) {
  std::vector<ArrivedSample> arrivals;
  for (int s = begin_s; s < end_s; ++s) arrivals.push_back(At(s - 0.5 - behind_s, s));
  return arrivals;
}

std::vector<ArrivedSample> operator+(std::vector<ArrivedSample> a,
                                     const std::vector<ArrivedSample>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST_CASE("flight clock: what arrives late is old, by its own time") {
  const ArrivedSample first = At(-200.0, -199.0), late = At(-90.0, 0.0);
  // A constant second is the way there, or a difference of clocks.
  CHECK(FlightClock({first}).AgeS(first, kNowUs) == 199.0);
  const FlightClock clock({first, late});
  CHECK(clock.AgeS(late, kNowUs) == 89.0);
  CHECK(clock.AgeS(late, kNowUs + 3 * kSecondUs) == 92.0);
}

TEST_CASE("flight clock: a clock that is off by a minute makes no sample old, an hour does") {
  for (const double behind_s : {-3000.0, -60.0, 60.0}) {
    // Alone, one that is far ahead sets no clock.
    const auto alone_s = FlightClock({At(-behind_s, 0.0)}).AgeS(At(-behind_s, 0.0), kNowUs);
    CHECK(alone_s == (behind_s < -120.0 ? std::nullopt : std::optional(0.0)));
    const std::vector<ArrivedSample> live = Live(0, 60, behind_s);
    CHECK(FlightClock(live).AgeS(live.back(), kNowUs + 60 * kSecondUs) == 1.0);
  }
  // Nothing of this flight ever arrived sooner.
  CHECK(FlightClock({At(-3600.0, 0.0)}).AgeS(At(-3600.0, 0.0), kNowUs) == 3600.0);
}

TEST_CASE("flight clock: times of another day, or of a clock that was never set, say nothing") {
  const ArrivedSample two_days_ago = At(-2.0 * 86400.0, 0.0), never_set{50 * kSecondUs, kNowUs};
  for (const ArrivedSample& sample : {two_days_ago, never_set}) {
    CHECK(FlightClock({sample}).AgeS(sample, kNowUs + kSecondUs) == 1.0);
  }
  CHECK_FALSE(FlightClock({}).AgeS({kNowUs, 0}, kNowUs));
  // So also where the clock was set until the aircraft's computer started again.
  CHECK(FlightClock(Live(-60, 0) + std::vector{never_set}).AgeS(never_set, kNowUs + kSecondUs) ==
        1.0);
  // What a link kept since then is as much older as it comes later than what is live.
  std::vector<ArrivedSample> restarted = Live(-60, 0);
  for (int s = 1; s <= 20; ++s) restarted.push_back({(50 + s) * kSecondUs, kNowUs + s * kSecondUs});
  const ArrivedSample live = restarted.back(), kept{30 * kSecondUs, live.arrived_at_us};
  for (const bool is_chain : {true, false}) {
    const FlightClock clock(is_chain ? restarted + std::vector{kept}
                                     : Live(-60, 0) + std::vector{live, kept});
    CHECK(clock.AgeS(live, live.arrived_at_us) == doctest::Approx(0.0));
    CHECK(clock.AgeS(kept, live.arrived_at_us) == doctest::Approx(40.0));
  }
  // Where the aircraft's clock is known to show this day, one of another day is old.
  CHECK(FlightClock(Live(-60, 0) + std::vector{two_days_ago}).AgeS(two_days_ago, kNowUs) ==
        doctest::Approx(2.0 * 86400.0).epsilon(1e-4));
}

TEST_CASE("one sample ahead: it makes no other one old, and is of unknown age itself") {
  for (const double ahead_s : {100.0, 12.0 * 3600.0, 86390.0}) {
    for (const double behind_s : {0.0, 60.0, -3000.0}) {
      INFO(ahead_s, " s ahead of a clock that is ", behind_s, " s behind");
      const std::vector<ArrivedSample> live = Live(0, 200, behind_s);
      const ArrivedSample ahead = At(50.5 + ahead_s - std::min(0.0, behind_s), 50.7);
      for (const bool comes_first : {false, true}) {
        const FlightClock clock(
            comes_first ? std::vector{At(ahead_s - std::min(0.0, behind_s), -0.5)} + live
                        : live + std::vector{ahead});
        CHECK(clock.AgeS(live.back(), kNowUs + 199 * kSecondUs) == doctest::Approx(0.0));
        CHECK_FALSE(clock.AgeS(ahead, kNowUs + 199 * kSecondUs));
      }
    }
  }
}

TEST_CASE(
    "one sample ahead: many that arrive together set no clock either, nor a few at the start") {
  std::vector<ArrivedSample> burst;
  burst.reserve(50);
  for (int i = 0; i < 50; ++i) burst.push_back(At(10.0 + 100.0 + 0.02 * i, 10.2));
  const std::vector<ArrivedSample> live = Live(0, 30);
  CHECK(FlightClock(live + burst).AgeS(live.back(), kNowUs + 29 * kSecondUs) ==
        doctest::Approx(0.0));
  CHECK_FALSE(FlightClock(live + burst).AgeS(burst.back(), kNowUs + 29 * kSecondUs));
  // All in one upload: what most samples say counts.
  std::vector<ArrivedSample> upload{At(43200.0, 0.0)};
  for (int s = 1; s <= 15; ++s) upload.push_back(At(-s, 0.0));
  CHECK(FlightClock(upload).AgeS(upload[1], kNowUs) == doctest::Approx(0.0));
  CHECK_FALSE(FlightClock(upload).AgeS(upload[0], kNowUs));
  // Two that contradict each other: the one that the server's clock agrees with.
  const std::vector<ArrivedSample> two{At(100.0, 0.0), At(0.8, 1.0)};
  CHECK(FlightClock(two).AgeS(two[1], kNowUs + kSecondUs) == doctest::Approx(0.0));
  CHECK_FALSE(FlightClock(two).AgeS(two[0], kNowUs + kSecondUs));
}

TEST_CASE(
    "one sample ahead: a clock that is set during the flight counts when it has been consistent") {
  // Ahead, which no link can do: after half as many seconds as before.
  const auto ahead = [](int num_s) { return Live(0, 20) + Live(20, 20 + num_s, -100.0); };
  const auto age_s = [](const std::vector<ArrivedSample>& arrivals) {
    return FlightClock(arrivals).AgeS(arrivals.back(), arrivals.back().arrived_at_us);
  };
  CHECK_FALSE(age_s(ahead(4)));
  CHECK(age_s(ahead(10)) == doctest::Approx(0.0));
  // Back, which may also be a link that is late: after twice as many.
  const auto back = [](int num_s) { return Live(0, 20) + Live(20, 20 + num_s, 100.0); };
  CHECK(age_s(back(30)) == doctest::Approx(100.0));
  CHECK(age_s(back(45)) == doctest::Approx(0.0));
}

TEST_CASE("one sample ahead: a clock far ahead that is set right counts after five seconds") {
  for (const double ahead_s : {200.0, 3600.0, 80000.0}) {
    for (const int num_wrong_s : {6, 15, 95}) {
      INFO(num_wrong_s, " s of a clock that is ", ahead_s, " s ahead");
      const auto with = [&](int num_good_s) {
        return Live(0, num_wrong_s, -ahead_s) + Live(num_wrong_s, num_wrong_s + num_good_s);
      };
      const std::vector<ArrivedSample> arrivals = with(5);
      const int64_t now_us = arrivals.back().arrived_at_us;
      CHECK(FlightClock(arrivals).AgeS(arrivals.back(), now_us) == doctest::Approx(0.0));
      CHECK_FALSE(FlightClock(arrivals).AgeS(arrivals.front(), now_us));
      // Before, what it told last grows old.
      const std::vector<ArrivedSample> few = with(4);
      CHECK(FlightClock(few).AgeS(few.back(), few.back().arrived_at_us).value() > ahead_s - 1.0);
    }
  }
}

TEST_CASE("flight clock: of a clock that was never set, what was kept is older than what is live") {
  for (const double behind_s : {2.0 * 86400.0, 1e-6 * kNowUs - 1000.0}) {
    const std::vector<ArrivedSample> live = Live(0, 6, behind_s);
    std::vector<ArrivedSample> kept;
    kept.reserve(5);
    for (int s = 0; s < 5; ++s) kept.push_back(At(s - 900.0 - behind_s, 6.0));
    const FlightClock clock(live + kept);
    CHECK(clock.AgeS(live.back(), kNowUs + 6 * kSecondUs) == doctest::Approx(1.0));
    CHECK(clock.AgeS(kept.back(), kNowUs + 6 * kSecondUs) == doctest::Approx(901.5));
  }
}

TEST_CASE("one sample ahead: where every time is another one, none is younger than its arrival") {
  std::vector<ArrivedSample> wild;
  wild.reserve(20);
  for (int s = 0; s < 20; ++s) wild.push_back(At(s + 500.0 * ((7 * s) % 20), s));
  const FlightClock clock(wild);
  for (const ArrivedSample& sample : wild) {
    const auto age_s = clock.AgeS(sample, kNowUs + 20 * kSecondUs);
    if (age_s) CHECK(*age_s >= 1e-6 * (kNowUs + 20 * kSecondUs - sample.arrived_at_us) - 1e-6);
  }
}

TEST_CASE("flight clock: a wind of another day does not blow today") {
  const ArrivedSample wind = At(-2.0 * 365.0 * 86400.0, 0.0);
  CHECK(WindAgeS(wind, 0.0, kNowUs) == doctest::Approx(2.0 * 365.0 * 86400.0));
  CHECK(WindAgeS(At(-60.0, 0.0), 0.5, kNowUs) == 0.5);
  CHECK(WindAgeS({1000, kNowUs}, 0.5, kNowUs) == 0.5);
  CHECK_FALSE(WindAgeS(At(-60.0, 0.0), std::nullopt, kNowUs));
}

TEST_CASE("arrival clock: it goes with the wall clock and never back") {
  const int64_t first_us = ArrivalNowUs();
  CHECK(std::abs(first_us - NowUs()) < 10 * kSecondUs);
  CHECK(ArrivalNowUs() >= first_us);
}

TEST_CASE("telemetry: only a set clock refuses a time ahead of it") {
  constexpr int64_t kYear2255Us = 9000000000000000;
  CHECK_THROWS_AS(RefuseFutureTime(kYear2255Us, kNowUs), ApiError);
  CHECK_NOTHROW(RefuseFutureTime(kNowUs + 23 * 3600 * kSecondUs, kNowUs));
  CHECK_NOTHROW(RefuseFutureTime(1, kNowUs));
  // 1970 and 2019: never set.
  CHECK_NOTHROW(RefuseFutureTime(kNowUs, 60 * kSecondUs));
  CHECK_NOTHROW(RefuseFutureTime(kYear2255Us, kFirstPlausibleUs - 1));
}

}  // namespace
}  // namespace freelsd
