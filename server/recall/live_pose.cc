#include "server/recall/live_pose.h"

#include <vector>

#include "api/stored/stored.h"
#include "server/intake/intake.h"
#include "server/recall/course/course.h"

namespace freelsd {
namespace {

// Enough for a course at 50 samples a second.
constexpr int kMaxNumSamples = 100;
constexpr int kMaxNumFrames = 8;

struct ArrivedWind {
  LiveWind wind;
  int64_t arrived_at_us = 0;
};

// Positions and last wind from one source.
struct Track {
  // In the order of arrival, the latest first.
  std::vector<PassedPosition> passed;
  std::optional<int64_t> timestamp_us;
  std::optional<std::string> altitude_datum;
  std::optional<ArrivedWind> wind;
};

Track TrackOfTelemetry(const Storage& storage, const std::string& flight_id) {
  Track track;
  const auto last = [&](TelemetryKind kind, int max_num_rows) {
    return storage.telemetry.LastArrived(flight_id, kind, max_num_rows);
  };
  for (const TelemetryRow& row : last(TelemetryKind::kPosition, kMaxNumSamples)) {
    const GeoPoint place{row.values[0], row.values[1], row.values[2]};
    if (track.passed.empty()) track.altitude_datum = AltitudeDatumOf(row);
    track.passed.push_back({place, row.timestamp_us, row.arrived_at_us});
  }
  if (!track.passed.empty()) track.timestamp_us = track.passed.front().timestamp_us;
  for (const TelemetryRow& row : last(TelemetryKind::kWind, 1)) {
    const LiveWind wind{{row.values[0], row.values[1]}, row.timestamp_us, std::nullopt};
    track.wind = ArrivedWind{wind, row.arrived_at_us};
  }
  return track;
}

// Uses only the metadata that arrived with the frames. Their metadata from telemetry arrived
// earlier.
Track TrackOfFrames(const Storage& storage, const std::string& flight_id) {
  Track track;
  for (const FrameRow& frame : storage.frames.LastArrived(flight_id, kMaxNumFrames)) {
    const FrameMeta meta =
        Merged(ParseStoredFrameMeta(frame.meta_json), ParseStoredFrameMeta(frame.tags_json));
    if (meta.wind_in_world && !track.wind) {
      const LiveWind wind{*meta.wind_in_world, meta.timestamp_us, std::nullopt};
      track.wind = ArrivedWind{wind, frame.arrived_at_us};
    }
    if (!meta.position) continue;
    if (track.passed.empty()) {
      track.timestamp_us = meta.timestamp_us;
      track.altitude_datum = meta.altitude_datum;
    }
    // Without times, only the latest one counts.
    if (!track.passed.empty() && !(meta.timestamp_us && track.timestamp_us)) continue;
    track.passed.push_back({*meta.position, meta.timestamp_us.value_or(0), frame.arrived_at_us});
  }
  return track;
}

bool IsLater(const Track& a, const Track& b) {
  if (a.passed.empty() || b.passed.empty()) return b.passed.empty();
  return a.passed.front().arrived_at_us > b.passed.front().arrived_at_us;
}

std::optional<LiveWind> LatestWind(const std::optional<ArrivedWind>& a,
                                   const std::optional<ArrivedWind>& b,
                                   int64_t now_us) {
  if (!a && !b) return std::nullopt;
  const bool is_a = !b || (a && a->arrived_at_us > b->arrived_at_us);
  const ArrivedWind& latest = is_a ? *a : *b;
  LiveWind wind = latest.wind;
  wind.age_s = AgeS(latest.arrived_at_us, now_us);
  return wind;
}

}  // namespace

std::optional<LivePose> LivePoseOf(const Storage& storage,
                                   const std::string& flight_id,
                                   int64_t now_us) {
  const Track telemetry = TrackOfTelemetry(storage, flight_id);
  const Track frames = TrackOfFrames(storage, flight_id);
  const Track& track = IsLater(telemetry, frames) ? telemetry : frames;
  if (track.passed.empty()) return std::nullopt;
  LivePose pose;
  pose.place = track.passed.front().place;
  pose.altitude_datum = track.altitude_datum;
  pose.timestamp_us = track.timestamp_us;
  pose.age_s = AgeS(track.passed.front().arrived_at_us, now_us);
  if (pose.age_s && *pose.age_s <= kMaxCourseAgeS) pose.heading_deg = CourseDeg(track.passed);
  pose.wind = LatestWind(telemetry.wind, frames.wind, now_us);
  return pose;
}

}  // namespace freelsd
