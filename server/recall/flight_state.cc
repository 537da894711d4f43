#include "server/recall/flight_state.h"

#include "api/api.h"
#include "api/stored/stored.h"
#include "server/intake/intake.h"
#include "server/recall/live_pose/live_pose.h"

namespace freelsd {
namespace {

// If the request's place is farther from the flight's latest position, the aircraft may have turned
// since.
constexpr double kMaxAwayM = 300.0;

// Nothing if the course is unknown or belongs to another place.
std::optional<double> CourseAt(const GeoPoint& place, const std::optional<LivePose>& pose) {
  if (!pose || !pose->heading_deg) return std::nullopt;
  const double away_m = LocalFrame(pose->place).WorldFromGeo(place).head<2>().norm();
  return away_m <= kMaxAwayM ? pose->heading_deg : std::nullopt;
}

std::string DatumOf(const FlightRow& flight, const std::optional<LivePose>& pose) {
  if (const auto told = ToldDatumOf(flight)) return *told;
  return pose ? pose->altitude_datum.value_or("unknown") : "unknown";
}

}  // namespace

CompletedRequest CompletedFromFlight(const Storage& storage, const EmergencyRequest& given) {
  const std::optional<FlightRow> flight = storage.flights.Find(given.flight_id.value());
  if (!flight) throw ApiError("NoSuchFlight", "there is no such flight");
  const std::optional<LivePose> pose = LivePoseOf(storage, flight->id, ArrivalNowUs());
  CompletedRequest completed{given, {{"flight_id", flight->id}}};
  EmergencyRequest& request = completed.request;
  nlohmann::json& taken = completed.taken;
  if (!request.altitude_datum) {
    request.altitude_datum = DatumOf(*flight, pose);
    taken["altitude_datum"] = *request.altitude_datum;
  }
  const StoredFlight stored = ParseStoredFlight(flight->request_json);
  request.is_of_experiment = !stored.memory.is_kept;
  if (!request.aircraft) {
    request.aircraft = stored.aircraft;
    taken["aircraft"] = AircraftJson(*request.aircraft);
  }
  if (pose && pose->wind && !request.wind_in_world) {
    request = InWind(request, WindOfNowOf(*pose->wind));
    taken["wind"] = WindJson(*pose->wind);
  }
  if (const auto course_deg = CourseAt(given.place, pose); course_deg && !request.heading_deg) {
    request.heading_deg = course_deg;
    taken["heading_deg"] = *course_deg;
  }
  if (pose && pose->timestamp_us) taken["timestamp_us"] = *pose->timestamp_us;
  return completed;
}

}  // namespace freelsd
