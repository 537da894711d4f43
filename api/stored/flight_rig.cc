#include <nlohmann/json.hpp>

#include "api/flight_parts.h"
#include "api/json_reader.h"
#include "api/stored/stored.h"

namespace freelsd {

std::string FlightRigJson(const FlightRig& flight_rig) {
  nlohmann::json object{{"camera", CameraJson(flight_rig.rig.camera)},
                        {"body_from_camera", Rigid3Json(flight_rig.rig.body_from_camera)},
                        {"origin", GeoPointJson(flight_rig.origin)}};
  if (flight_rig.altitude_datum) object["altitude_datum"] = *flight_rig.altitude_datum;
  return object.dump();
}

FlightRig ParseStoredFlightRig(const std::string& text) {
  const nlohmann::json object = ParseJson(text);
  ObjectReader reader(object, "");
  FlightRig flight_rig;
  flight_rig.rig.camera = ParseCamera(reader.Required("camera"), "/camera", CameraOrigin::kStored);
  flight_rig.rig.body_from_camera =
      ParseRigid3(reader.Required("body_from_camera"), "/body_from_camera");
  flight_rig.origin = ReadGeoPoint(reader.Required("origin"), "/origin");
  if (const nlohmann::json* const datum = reader.Find("altitude_datum")) {
    flight_rig.altitude_datum = ReadString(*datum, "/altitude_datum");
  }
  return flight_rig;
}

}  // namespace freelsd
