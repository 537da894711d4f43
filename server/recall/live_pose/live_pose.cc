#include "server/recall/live_pose/live_pose.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "api/stored/stored.h"
#include "server/intake/intake.h"
#include "server/recall/live_pose/course.h"

namespace freelsd {
namespace {

// Enough for a course at 50 samples a second.
constexpr int kMaxNumSamples = 100;
constexpr int kMaxNumFrames = 8;
// For this time a wind that someone measured counts more than one from drift.
constexpr double kGivenWindHoldsForS = 60.0;

// A sample and its age; the age of one whose time of arrival is unknown is infinite.
struct AgedRow {
  TelemetryRow row;
  std::optional<double> age_s;

  double SortAgeS() const { return age_s.value_or(std::numeric_limits<double>::infinity()); }
};

// Positions from one source.
struct Track {
  // The latest first.
  std::vector<PassedPosition> passed;
  std::optional<int64_t> timestamp_us;
  std::optional<std::string> altitude_datum;
  std::optional<double> age_s;
};

// Telemetry of a flight, from which poses and winds are taken.
struct FlightSamples {
  std::vector<TelemetryRow> positions, winds;
  FlightClock clock;
};

ArrivedSample ArrivalOf(const TelemetryRow& row) { return {row.timestamp_us, row.arrived_at_us}; }

FlightSamples SamplesOf(const Storage& storage, const std::string& flight_id) {
  std::vector<ArrivedSample> arrivals;
  const auto recent = [&](TelemetryKind kind) {
    auto rows = storage.telemetry.Recent(flight_id, kind, kMaxNumSamples);
    std::transform(rows.begin(), rows.end(), std::back_inserter(arrivals), ArrivalOf);
    return rows;
  };
  auto positions = recent(TelemetryKind::kPosition);
  auto winds = recent(TelemetryKind::kWind);
  return {std::move(positions), std::move(winds), FlightClock(std::move(arrivals))};
}

// The youngest rows, the latest first. What arrived last may be old, and the row with the latest
// timestamp may be of a clock that was wrong.
std::vector<AgedRow> Youngest(const std::vector<TelemetryRow>& rows,
                              const FlightClock& clock,
                              int64_t now_us) {
  std::vector<AgedRow> aged;
  aged.reserve(rows.size());
  for (const TelemetryRow& row : rows) {
    aged.push_back({row, clock.AgeS(ArrivalOf(row), now_us)});
  }
  std::sort(aged.begin(), aged.end(), [](const AgedRow& a, const AgedRow& b) {
    return std::pair(a.SortAgeS(), -a.row.arrived_at_us) <
           std::pair(b.SortAgeS(), -b.row.arrived_at_us);
  });
  if (aged.size() > static_cast<size_t>(kMaxNumSamples)) aged.resize(kMaxNumSamples);
  return aged;
}

Track TrackOfTelemetry(const FlightSamples& samples, int64_t now_us) {
  Track track;
  for (const auto& [row, age_s] : Youngest(samples.positions, samples.clock, now_us)) {
    if (track.passed.empty()) {
      track.timestamp_us = row.timestamp_us;
      track.altitude_datum = AltitudeDatumOf(row);
      track.age_s = age_s;
    }
    const GeoPoint place{row.values[0], row.values[1], row.values[2]};
    track.passed.push_back({place, row.timestamp_us, row.arrived_at_us});
  }
  return track;
}

FrameMeta MetaOf(const FrameRow& frame) {
  return Merged(ParseStoredFrameMeta(frame.meta_json), ParseStoredFrameMeta(frame.tags_json));
}

// A batch arrives long after its photographs were taken: only their own times say when.
std::optional<double> FrameAgeS(const FrameRow& frame, const FrameMeta& meta, int64_t now_us) {
  if (!frame.is_from_batch) return AgeS(frame.arrived_at_us, now_us);
  const CaptureTime taken = CaptureTimeOf(frame, meta);
  if (!taken.IsDated() || taken.earliest_us > now_us) return std::nullopt;
  return static_cast<double>(now_us - taken.earliest_us) * 1e-6;
}

// A frame may be sent long after it was taken. Its position is then still the last one that
// arrived, because cameras' clocks are often wrong, but its wind is not one of now.
std::optional<double> FrameWindAgeS(const FrameRow& frame, const FrameMeta& meta, int64_t now_us) {
  constexpr int64_t kMaxPromptUs = int64_t{120} * 1000000;
  const int64_t taken_us = meta.timestamp_us.value_or(0);
  const auto age_s =
      WindAgeS({taken_us, frame.arrived_at_us}, FrameAgeS(frame, meta, now_us), now_us);
  const bool is_late = taken_us > 0 && frame.arrived_at_us - taken_us > kMaxPromptUs;
  if (!age_s || !is_late) return age_s;
  return std::max(*age_s, static_cast<double>(now_us - taken_us) * 1e-6);
}

// Uses only the metadata that arrived with the frames. Their metadata from telemetry arrived
// earlier.
Track TrackOfFrames(const std::vector<FrameRow>& frames, int64_t now_us) {
  Track track;
  for (const FrameRow& frame : frames) {
    const FrameMeta meta = MetaOf(frame);
    if (!meta.position) continue;
    if (track.passed.empty()) {
      track.timestamp_us = meta.timestamp_us;
      track.altitude_datum = meta.altitude_datum;
      track.age_s = FrameAgeS(frame, meta, now_us);
    }
    // Without times, only the latest one counts.
    if (!track.passed.empty() && !(meta.timestamp_us && track.timestamp_us)) continue;
    track.passed.push_back({*meta.position, meta.timestamp_us.value_or(0), frame.arrived_at_us});
  }
  return track;
}

// What is of unknown age is older. Where both are, the order of arrival counts.
bool IsLater(const Track& a, const Track& b) {
  if (a.passed.empty() || b.passed.empty()) return b.passed.empty();
  if (a.age_s && b.age_s) return *a.age_s < *b.age_s;
  if (a.age_s.has_value() != b.age_s.has_value()) return a.age_s.has_value();
  return a.passed.front().arrived_at_us > b.passed.front().arrived_at_us;
}

std::optional<LiveWind> WindOfFrames(const std::vector<FrameRow>& frames, int64_t now_us) {
  for (const FrameRow& frame : frames) {
    const FrameMeta meta = MetaOf(frame);
    if (!meta.wind_in_world) continue;
    return LiveWind{*meta.wind_in_world,
                    meta.timestamp_us,
                    FrameWindAgeS(frame, meta, now_us),
                    "frame",
                    std::nullopt};
  }
  return std::nullopt;
}

// Least for the wind to take.
std::pair<bool, double> OrderOf(const LiveWind& wind) {
  const double age_s = wind.age_s.value_or(std::numeric_limits<double>::infinity());
  const bool is_given = wind.source != "drift" && age_s <= kGivenWindHoldsForS;
  return {!is_given, age_s};
}

std::optional<LiveWind> WindOf(const FlightSamples& samples,
                               const std::vector<FrameRow>& frames,
                               int64_t now_us) {
  std::vector<LiveWind> winds;
  for (const auto& [row, age_s] : Youngest(samples.winds, samples.clock, now_us)) {
    winds.push_back({{row.values[0], row.values[1]},
                     row.timestamp_us,
                     WindAgeS(ArrivalOf(row), age_s, now_us),
                     WindSourceOf(row),
                     WindSdMps(row)});
  }
  if (const auto wind = WindOfFrames(frames, now_us)) winds.push_back(*wind);
  const auto best =
      std::min_element(winds.begin(), winds.end(), [](const LiveWind& a, const LiveWind& b) {
        return OrderOf(a) < OrderOf(b);
      });
  return best == winds.end() ? std::nullopt : std::optional(*best);
}

}  // namespace

std::optional<LiveWind> LiveWindOf(const Storage& storage,
                                   const std::string& flight_id,
                                   int64_t now_us) {
  return WindOf(
      SamplesOf(storage, flight_id), storage.frames.LastArrived(flight_id, kMaxNumFrames), now_us);
}

std::optional<LivePose> LivePoseOf(const Storage& storage,
                                   const std::string& flight_id,
                                   int64_t now_us) {
  const FlightSamples samples = SamplesOf(storage, flight_id);
  const std::vector<FrameRow> frames = storage.frames.LastArrived(flight_id, kMaxNumFrames);
  const Track of_telemetry = TrackOfTelemetry(samples, now_us);
  const Track of_frames = TrackOfFrames(frames, now_us);
  const Track& track = IsLater(of_telemetry, of_frames) ? of_telemetry : of_frames;
  if (track.passed.empty()) return std::nullopt;
  LivePose pose;
  pose.place = track.passed.front().place;
  pose.altitude_datum = track.altitude_datum;
  pose.timestamp_us = track.timestamp_us;
  pose.age_s = track.age_s;
  if (pose.age_s && *pose.age_s <= kMaxCourseAgeS) pose.heading_deg = CourseDeg(track.passed);
  pose.wind = WindOf(samples, frames, now_us);
  return pose;
}

}  // namespace freelsd
