#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/api.h"
#include "tests/api/errors.h"

namespace freelsd {
namespace {

TEST_CASE("aircraft: written and read again nothing is lost") {
  Aircraft aircraft = AircraftProfile("atlantiksolar").value();
  aircraft.glide_airspeed_mps = 11.5;
  const nlohmann::json written = AircraftJson(aircraft);
  CHECK(AircraftJson(ParseAircraft(written, "")) == written);
  CHECK(ErrorOf([] {
          ParseAircraft({{"glide_ratio", 0.0}}, "/plane");
        }) == "422 InvalidValue /plane/glide_ratio");
}

}  // namespace
}  // namespace freelsd
