#include "server/intake/arrival_clock.h"

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
  // An older version stored no arrival.
  CHECK_FALSE(AgeS(0, kNowUs));
  CHECK_FALSE(AgeS(-5, 100 * kSecondUs));
}

TEST_CASE("flight clock: what arrives late is old, by its own time") {
  FlightClock clock;
  clock.Hear(kNowUs - 200 * kSecondUs, kNowUs - 199 * kSecondUs);
  // A constant second is the way there, or a difference of clocks.
  CHECK(clock.AgeS(kNowUs - 200 * kSecondUs, kNowUs - 199 * kSecondUs, kNowUs) == 199.0);
  clock.Hear(kNowUs - 90 * kSecondUs, kNowUs);
  CHECK(clock.AgeS(kNowUs - 90 * kSecondUs, kNowUs, kNowUs) == 89.0);
  CHECK(clock.AgeS(kNowUs - 90 * kSecondUs, kNowUs, kNowUs + 3 * kSecondUs) == 92.0);
}

TEST_CASE("flight clock: a clock that is off by a minute makes no sample old, an hour does") {
  for (const int64_t error_s : {-3000, -60, 60}) {
    FlightClock clock;
    clock.Hear(kNowUs - error_s * kSecondUs, kNowUs);
    CHECK(clock.AgeS(kNowUs - error_s * kSecondUs, kNowUs, kNowUs) == 0.0);
  }
  // Nothing of this flight ever arrived sooner.
  FlightClock clock;
  clock.Hear(kNowUs - 3600 * kSecondUs, kNowUs);
  CHECK(clock.AgeS(kNowUs - 3600 * kSecondUs, kNowUs, kNowUs) == 3600.0);
}

TEST_CASE("flight clock: times of another day, or of a clock that was never set, say nothing") {
  FlightClock clock;
  for (const int64_t timestamp_us : {kNowUs - 2 * 86400 * kSecondUs, 50 * kSecondUs}) {
    clock.Hear(timestamp_us, kNowUs);
    CHECK(clock.AgeS(timestamp_us, kNowUs, kNowUs + kSecondUs) == 1.0);
  }
  CHECK_FALSE(clock.AgeS(kNowUs, 0, kNowUs));
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
