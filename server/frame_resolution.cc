#include "server/frame_resolution.h"

#include <cmath>

#include "server/intake.h"
#include "server/telemetry.h"

namespace freelsd {
namespace {

Resolution Reject(Service& service, FrameRow& frame, const std::string& why) {
  service.storage.SetFrameState(frame.flight_id, frame.id, FrameState::kRejected, why);
  frame.state = FrameState::kRejected;
  frame.reason = why;
  return Resolution::kRejected;
}

// One flight is one flat world: at this distance the plumb line is half a degree off. What is
// farther away is a wrong fix, or another flight.
std::optional<std::string> WhyTooFar(const GeoPoint& place, const std::string& rig_json) {
  constexpr double kMaxDistanceM = 50000.0;
  const LocalFrame local_frame(ParseStoredFlightRig(rig_json).origin);
  const double distance_m = local_frame.WorldFromGeo(place).head<2>().norm();
  if (distance_m <= kMaxDistanceM) return std::nullopt;
  return "its position is " + std::to_string(std::lround(distance_m / 1000.0)) +
         " km from the flight's origin, at most 50 km";
}

}  // namespace

FrameMeta KnownMeta(const Service& service,
                    const std::string& flight_id,
                    const FrameMeta& given,
                    const FrameMeta& tags) {
  const std::optional<int64_t> timestamp_us =
      given.timestamp_us ? given.timestamp_us : tags.timestamp_us;
  if (!timestamp_us) return Merged(given, tags);
  const FrameMeta telemetry =
      TelemetryAt(service.storage, service.config, flight_id, *timestamp_us);
  return Merged(Merged(given, telemetry), tags);
}

Resolution ResolveFrame(Service& service, const FlightRow& flight, FrameRow& frame, bool may_wait) {
  const FrameMeta meta = KnownMeta(service,
                                   flight.id,
                                   ParseStoredFrameMeta(frame.meta_json),
                                   ParseStoredFrameMeta(frame.tags_json));
  if (!meta.position && may_wait) return Resolution::kWaiting;
  if (!meta.position) return Reject(service, frame, "no telemetry told its position in time");
  std::string rig_json = flight.rig_json;
  if (rig_json.empty()) {
    const std::optional<std::string> bytes = service.storage.ReadImage(frame.sha256);
    if (!bytes) return Reject(service, frame, "its image file is gone");
    try {
      RigResolver resolver(flight);
      resolver.Admit(CheckImage(service, *bytes), meta);
      rig_json = resolver.RigJson();
    } catch (const ApiError& error) {
      return Reject(service, frame, error.what());
    }
  }
  if (const auto why = WhyTooFar(*meta.position, rig_json)) return Reject(service, frame, *why);
  frame.resolved_json = FrameMetaJson(meta);
  service.storage.ResolveFrame(
      flight.id, frame.id, frame.resolved_json, [&](FlightRow& row) { row.rig_json = rig_json; });
  return Resolution::kReady;
}

void RefuseWhenRetired(const FlightRow& flight) {
  if (!flight.has_retired_images) return;
  throw ApiError("Conflict", "the flight is over: its images were removed to make room");
}

}  // namespace freelsd
