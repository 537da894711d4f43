#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/stored/stored.h"
#include "tests/api/errors.h"

namespace freelsd {
namespace {

TEST_CASE("rig: stored and read again without loss, with the camera's source") {
  FlightRig flight_rig;
  Camera& camera = flight_rig.rig.camera;
  camera.width_px = 4000;
  camera.height_px = 3000;
  camera.fx_px = 2777.1;
  camera.fy_px = 2777.2;
  camera.cx_px = 1999.5;
  camera.cy_px = 1499.5;
  camera.source = CameraSource::kExif;
  flight_rig.origin = {54.5090622, -2.7582823, 260.123456789};
  const std::string stored = FlightRigJson(flight_rig);
  const FlightRig read = ParseStoredFlightRig(stored);
  CHECK(FlightRigJson(read) == stored);
  CHECK(read.rig.camera.source == CameraSource::kExif);
  CHECK(read.origin.altitude_m == flight_rig.origin.altitude_m);
}

}  // namespace
}  // namespace freelsd
