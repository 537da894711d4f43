#include <stdexcept>

#include <doctest/doctest.h>

#include "engine/flight/flight.h"

namespace freelsd {
namespace {

TEST_CASE("aircraft: three profiles as in the contract, and limits that speak") {
  CHECK(AircraftProfile("techpod")->landing_airspeed_mps == 13.0);
  CHECK(AircraftProfile("atlantiksolar")->landing_airspeed_mps == 9.0);
  CHECK(AircraftProfile("small")->ground_roll_m == 15.0);
  CHECK_FALSE(AircraftProfile("zeppelin"));
  Aircraft aircraft;
  aircraft.max_bank_deg = 95.0;
  CHECK_THROWS_WITH_AS(
      aircraft.Check(), "aircraft.max_bank_deg = 95: must be in [1, 80]", std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
