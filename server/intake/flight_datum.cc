#include "server/intake/flight_datum.h"

#include "api/stored/stored.h"
#include "server/intake/warnings.h"

namespace freelsd {
namespace {

constexpr char kUnknown[] = "unknown";

std::optional<std::string> DatumOfFrames(const FlightRow& flight) {
  if (flight.rig_json.empty()) return std::nullopt;
  return ParseStoredFlightRig(flight.rig_json).altitude_datum;
}

// Contradictions between the datums of the frames and the client's, or among the frames. Empty if
// there are none.
std::vector<std::string> Contradictions(const std::optional<std::string>& given,
                                        const std::optional<std::string>& before,
                                        const std::string& told) {
  if (given && *given != kUnknown && told != kUnknown && told != *given) {
    return {"the datum of the altitudes is given as " + *given +
            ", but photographs or poses state " + told + ": the given one is used"};
  }
  if (!given && before && *before != told) {
    return {
        "the altitudes of the frames have different datums, or some have no known datum: the datum "
        "of the flight is unknown"};
  }
  return {};
}

}  // namespace

std::optional<std::string> ToldDatumOf(const FlightRow& flight) {
  const StoredFlight request = ParseStoredFlight(flight.request_json);
  return request.altitude_datum ? request.altitude_datum : DatumOfFrames(flight);
}

std::string AltitudeDatumOf(const FlightRow& flight) {
  return ToldDatumOf(flight).value_or(kUnknown);
}

std::string CommonDatum(const std::optional<std::string>& so_far, const FrameMeta& meta) {
  const std::string told = meta.altitude_datum.value_or(kUnknown);
  return !so_far || *so_far == told ? told : kUnknown;
}

FlightRow WithDatumOf(FlightRow flight, const FrameMeta& meta) {
  FlightRig rig = ParseStoredFlightRig(flight.rig_json);
  const std::optional<std::string> before = rig.altitude_datum;
  const std::string told = meta.altitude_datum.value_or(kUnknown);
  if (before == told) return flight;
  rig.altitude_datum = CommonDatum(before, meta);
  flight.rig_json = FlightRigJson(rig);
  const std::optional<std::string> given = ParseStoredFlight(flight.request_json).altitude_datum;
  flight.warnings_json =
      AddWarnings(flight.warnings_json, "altitude_datum", Contradictions(given, before, told));
  return flight;
}

}  // namespace freelsd
