#include "server/recall/flight_state.h"

#include <limits>

#include "api/api.h"
#include "api/stored/stored.h"
#include "server/intake/intake.h"

namespace freelsd {
namespace {

// Two positions show a track if they are near in time and far enough apart for their errors.
constexpr int64_t kMinTrackUs = 1000000;
constexpr int64_t kMaxTrackUs = 10000000;
constexpr double kMinTrackM = 5.0;
// Farther from the flight's latest position the aircraft may have turned since.
constexpr double kMaxAwayM = 300.0;

// The last position, and one shortly before it; both may be absent.
struct LastPoses {
  FrameMeta last;
  std::optional<GeoPoint> before;
};

LastPoses LastOfTelemetry(const Storage& storage, const std::string& flight_id) {
  LastPoses poses;
  poses.last = LatestTelemetry(storage, flight_id);
  if (!poses.last.timestamp_us) return poses;
  const int64_t now_us = *poses.last.timestamp_us;
  // Times of clients are arbitrary: the difference must not overflow.
  if (now_us < std::numeric_limits<int64_t>::min() + kMaxTrackUs) return poses;
  const auto before =
      storage.telemetry.Around(flight_id, TelemetryKind::kPosition, now_us - kMinTrackUs).before;
  if (before && before->timestamp_us >= now_us - kMaxTrackUs) {
    poses.before = GeoPoint{before->values[0], before->values[1], before->values[2]};
  }
  return poses;
}

LastPoses LastOfFrames(const Storage& storage, const std::string& flight_id) {
  LastPoses poses;
  const auto pose_of = [](const FrameRow& row) {
    return ParseStoredPose(row.resolved_json, row.meta_json, row.tags_json);
  };
  const std::optional<FrameRow> last = storage.frames.Last(flight_id);
  if (!last) return poses;
  poses.last = pose_of(*last);
  const std::optional<FrameRow> before = storage.frames.Next(flight_id, last->sequence - 2);
  if (!before || !poses.last.timestamp_us) return poses;
  const FrameMeta earlier = pose_of(*before);
  if (!earlier.timestamp_us || *earlier.timestamp_us >= *poses.last.timestamp_us) return poses;
  // Unsigned, because the difference of two arbitrary int64 times may overflow.
  const uint64_t passed_us = static_cast<uint64_t>(*poses.last.timestamp_us) -
                             static_cast<uint64_t>(*earlier.timestamp_us);
  if (passed_us <= static_cast<uint64_t>(kMaxTrackUs)) poses.before = earlier.position;
  return poses;
}

// The later of both sources. Wind may come from the other one.
LastPoses LastPosesOf(const Storage& storage, const std::string& flight_id) {
  LastPoses telemetry = LastOfTelemetry(storage, flight_id);
  LastPoses frames = LastOfFrames(storage, flight_id);
  const bool is_frame_later = frames.last.position && (!telemetry.last.position ||
                                                       frames.last.timestamp_us.value_or(0) >
                                                           telemetry.last.timestamp_us.value_or(0));
  LastPoses& later = is_frame_later ? frames : telemetry;
  const LastPoses& other = is_frame_later ? telemetry : frames;
  if (!later.last.wind_in_world) later.last.wind_in_world = other.last.wind_in_world;
  return later;
}

// Degrees from north, in [0, 360).
std::optional<double> TrackDeg(const LastPoses& poses, const GeoPoint& place) {
  if (!poses.last.position || !poses.before) return std::nullopt;
  const LocalFrame here(*poses.last.position);
  if (here.WorldFromGeo(place).head<2>().norm() > kMaxAwayM) return std::nullopt;
  const Eigen::Vector2d way = -here.WorldFromGeo(*poses.before).head<2>();
  if (way.norm() < kMinTrackM) return std::nullopt;
  const double track_deg = DegFromRad(HeadingOf(way));
  return track_deg < 0.0 ? track_deg + 360.0 : track_deg;
}

}  // namespace

CompletedRequest CompletedFromFlight(const Storage& storage, const EmergencyRequest& given) {
  const std::optional<FlightRow> flight = storage.flights.Find(given.flight_id.value());
  if (!flight) throw ApiError("NoSuchFlight", "there is no such flight");
  const LastPoses poses = LastPosesOf(storage, flight->id);
  CompletedRequest completed{given, {{"flight_id", flight->id}}};
  EmergencyRequest& request = completed.request;
  nlohmann::json& taken = completed.taken;
  if (!request.altitude_datum) {
    const std::optional<std::string> told = ToldDatumOf(*flight);
    request.altitude_datum = told ? *told : poses.last.altitude_datum.value_or("unknown");
    taken["altitude_datum"] = *request.altitude_datum;
  }
  if (!request.aircraft) {
    request.aircraft = ParseFlightRequest(flight->request_json).aircraft;
    taken["aircraft"] = AircraftJson(*request.aircraft);
  }
  if (const auto& wind = poses.last.wind_in_world; wind && !request.wind_in_world) {
    request.wind_in_world = wind;
    taken["wind"] = {{"east_mps", wind->x()}, {"north_mps", wind->y()}};
  }
  if (const auto track_deg = TrackDeg(poses, given.place); track_deg && !request.heading_deg) {
    request.heading_deg = track_deg;
    taken["heading_deg"] = *track_deg;
  }
  if (poses.last.timestamp_us) taken["timestamp_us"] = *poses.last.timestamp_us;
  return completed;
}

}  // namespace freelsd
