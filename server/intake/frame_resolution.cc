#include "server/intake/frame_resolution.h"

#include <algorithm>
#include <cmath>

#include "server/intake/checked_image.h"
#include "server/intake/flight_datum.h"
#include "server/intake/telemetry.h"

namespace freelsd {
namespace {

Resolution Reject(Intake& intake, FrameRow& frame, const std::string& why) {
  intake.storage.frames.SetState(frame.flight_id, frame.id, FrameState::kRejected, why);
  frame.state = FrameState::kRejected;
  frame.reason = why;
  return Resolution::kRejected;
}

// Why a position cannot be used. A flight has one flat world frame; 50 km from its origin the plumb
// line is half a degree off. A frame farther away is a wrong fix, or belongs to another flight.
std::optional<std::string> WhyTooFar(const GeoPoint& place, const std::string& rig_json) {
  constexpr double kMaxDistanceM = 50000.0;
  const LocalFrame local_frame(ParseStoredFlightRig(rig_json).origin);
  const double distance_m = local_frame.WorldFromGeo(place).head<2>().norm();
  if (distance_m <= kMaxDistanceM) return std::nullopt;
  return "its position is " + std::to_string(std::lround(distance_m / 1000.0)) +
         " km from the flight's origin; the limit is 50 km";
}

}  // namespace

CaptureTime CaptureTimeOf(const FrameRow& frame, const FrameMeta& meta) {
  return CaptureTimeOf(
      meta.timestamp_us, meta.time_source, {frame.arrived_at_us, !frame.is_from_batch});
}

std::vector<std::string> TimeWarnings(const std::vector<CaptureTime>& times,
                                      int64_t arrived_at_us) {
  // Cards are read sooner.
  constexpr int64_t kDayUs = int64_t{86400} * 1000000, kMaxDaysOnCard = 30;
  const auto has = [&times](const auto& is_it) {
    return std::any_of(times.begin(), times.end(), is_it);
  };
  std::vector<std::string> warnings;
  if (has([](const CaptureTime& time) { return !time.IsDated(); })) {
    warnings.emplace_back(
        "photographs have no usable date: when they show the ground is unknown, and they refresh "
        "nothing");
  }
  if (has([](const CaptureTime& time) { return time.source == TimeSource::kCameraLocal; })) {
    warnings.emplace_back(
        "the times of photographs have no offset from UTC: they are uncertain by 14 hours");
  }
  CaptureTime newest;
  newest.latest_us = 0;
  for (const CaptureTime& time : times) {
    if (time.IsDated()) newest = Newest(newest, time);
  }
  const int64_t num_days = (arrived_at_us - newest.latest_us) / kDayUs;
  if (newest.IsDated() && num_days >= kMaxDaysOnCard) {
    warnings.push_back("the newest photograph is dated " + std::to_string(num_days) +
                       " days before it arrived: if it is new, the camera's clock is wrong");
  }
  return warnings;
}

FrameMeta KnownMeta(const Intake& intake,
                    const std::string& flight_id,
                    const FrameMeta& given,
                    const FrameMeta& tags) {
  const std::optional<int64_t> timestamp_us =
      given.timestamp_us ? given.timestamp_us : tags.timestamp_us;
  if (!timestamp_us) return Merged(given, tags);
  const FrameMeta telemetry = TelemetryAt(intake.storage, intake.config, flight_id, *timestamp_us);
  return Merged(Merged(given, telemetry), tags);
}

PosedFrame::PosedFrame(FrameRow frame_row) : row(std::move(frame_row)) {
  if (!row.resolved_json.empty()) meta = ParseStoredFrameMeta(row.resolved_json);
}

Resolution ResolveFrame(Intake& intake, const FlightRow& flight, PosedFrame& posed, bool may_wait) {
  FrameRow& frame = posed.row;
  const FrameMeta meta = KnownMeta(intake,
                                   flight.id,
                                   ParseStoredFrameMeta(frame.meta_json),
                                   ParseStoredFrameMeta(frame.tags_json));
  if (!meta.position && may_wait) return Resolution::kWaiting;
  if (!meta.position) return Reject(intake, frame, "no telemetry gave its position in time");
  std::string rig_json = flight.rig_json;
  if (rig_json.empty()) {
    const std::optional<std::string> bytes = intake.storage.images.Read(frame.sha256);
    if (!bytes) return Reject(intake, frame, "its image file is missing");
    try {
      RigResolver resolver(flight);
      resolver.Admit(CheckImage(intake, *bytes), meta);
      rig_json = resolver.RigJson();
    } catch (const ApiError& error) {
      return Reject(intake, frame, error.what());
    }
  }
  if (const auto why = WhyTooFar(*meta.position, rig_json)) return Reject(intake, frame, *why);
  frame.resolved_json = FrameMetaJson(meta);
  intake.storage.frames.Resolve(flight.id, frame.id, frame.resolved_json, [&](FlightRow& row) {
    if (row.rig_json.empty()) row.rig_json = rig_json;
    row = WithDatumOf(std::move(row), meta);
  });
  posed.meta = meta;
  return Resolution::kReady;
}

void RefuseWhenRetired(const FlightRow& flight) {
  if (!flight.has_retired_images) return;
  throw ApiError("Conflict", "the flight is closed: its images were removed to free disk space");
}

}  // namespace freelsd
