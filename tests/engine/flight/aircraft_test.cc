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

TEST_CASE("aircraft: limits that no profile has are named, stricter ones are not") {
  for (const std::string& name : AircraftProfileNames()) {
    CHECK(LimitsLooserThanProfiles(*AircraftProfile(name)).empty());
  }
  Aircraft aircraft;
  aircraft.max_slope_deg = 60.0;
  aircraft.safety_margin_m = 0.0;
  const std::vector<std::string> looser = LimitsLooserThanProfiles(aircraft);
  REQUIRE(looser.size() == 2);
  CHECK(looser[0] == "slope 60 deg (profiles: at most 8 deg)");
  CHECK(looser[1] == "clearance above obstacles 0 m (profiles: at least 2 m)");
  Aircraft careful;
  careful.max_slope_deg = 2.0;
  careful.ground_roll_m = 200.0;
  CHECK(LimitsLooserThanProfiles(careful).empty());
}

TEST_CASE("aircraft: a final or a circle of many kilometres is refused") {
  Aircraft flat;
  flat.approach_height_m = 500.0;
  flat.flight_path_angle_deg = 0.5;
  CHECK_THROWS_AS(flat.Check(), std::invalid_argument);
  Aircraft wide;
  wide.landing_airspeed_mps = 100.0;
  wide.max_bank_deg = 1.0;
  CHECK_THROWS_AS(wide.Check(), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
