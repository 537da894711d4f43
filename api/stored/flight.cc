#include <nlohmann/json.hpp>

#include "api/flight_parts.h"
#include "api/json_reader.h"
#include "api/stored/stored.h"

namespace freelsd {

StoredFlight ParseStoredFlight(const std::string& request_json) {
  using Event = nlohmann::json::parse_event_t;
  const nlohmann::json object =
      nlohmann::json::parse(request_json, [](int depth, Event event, const nlohmann::json& parsed) {
        return depth != 1 || event != Event::key || parsed != "options";
      });
  ObjectReader reader(object, "");
  StoredFlight flight;
  if (const nlohmann::json* const camera = reader.Find("camera")) {
    flight.camera = ParseCamera(*camera, "/camera", CameraOrigin::kStored);
  }
  if (const nlohmann::json* const origin = reader.Find("origin")) {
    flight.origin = ReadGeoPoint(*origin, "/origin");
  }
  if (const nlohmann::json* const datum = reader.Find("altitude_datum")) {
    flight.altitude_datum = ReadString(*datum, "/altitude_datum");
  }
  if (const nlohmann::json* const aircraft = reader.Find("aircraft")) {
    flight.aircraft = ParseAircraft(*aircraft, "/aircraft");
  }
  flight.memory = {reader.Required("memory") == NameOf(FlightMemory{}),
                   ReadString(reader.Required("memory_reason"), "/memory_reason")};
  return flight;
}

}  // namespace freelsd
