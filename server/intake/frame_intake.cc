#include "server/intake/frame_intake.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/stored/stored.h"
#include "server/intake/checked_image.h"
#include "server/intake/frame_resolution.h"
#include "server/intake/telemetry.h"
#include "server/intake/warnings.h"

namespace freelsd {
namespace {

nlohmann::json AttitudeJson(const FrameMeta& meta) {
  const auto& ned_from_x = meta.ned_from_camera ? meta.ned_from_camera : meta.ned_from_body;
  if (!ned_from_x) return nullptr;
  // The camera looks along its z, the aircraft along its x. Down is positive in north-east-down.
  const Eigen::Vector3d axis =
      *ned_from_x * (meta.ned_from_camera ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX());
  return {
      {"of", meta.ned_from_camera ? "camera" : "aircraft"},
      {"pitch_deg", -DegFromRad(std::asin(std::clamp(axis.z(), -1.0, 1.0)))},
      {"quaternion_wxyz", {ned_from_x->w(), ned_from_x->x(), ned_from_x->y(), ned_from_x->z()}}};
}

bool IsAt(const FrameMeta& source, const GeoPoint& place) {
  return source.position && source.position->latitude_deg == place.latitude_deg &&
         source.position->longitude_deg == place.longitude_deg;
}

// Null without a position.
nlohmann::json PoseJson(const FrameRow& frame, const FrameMeta& meta) {
  if (!meta.position) return nullptr;
  const bool is_given = IsAt(ParseStoredFrameMeta(frame.meta_json), *meta.position);
  const bool is_tagged = IsAt(ParseStoredFrameMeta(frame.tags_json), *meta.position);
  return {{"position", GeoPointJson(*meta.position)},
          {"attitude", AttitudeJson(meta)},
          {"altitude_datum", meta.altitude_datum.value_or("unknown")},
          {"source",
           is_given    ? "given"
           : is_tagged ? "tags"
                       : "telemetry"}};
}

const char* StateName(FrameState state) {
  constexpr const char* kNames[] = {"queued", "processed", "rejected"};
  return kNames[static_cast<int>(state)];
}

FlightRow OpenFlight(const Intake& intake, const std::string& flight_id) {
  const std::optional<FlightRow> flight = intake.storage.flights.Find(flight_id);
  if (!flight) throw ApiError("NoSuchFlight", "there is no such flight");
  RefuseWhenRetired(*flight);
  return *flight;
}

void StoreFrame(Intake& intake,
                const FrameUpload& upload,
                const FrameRow& frame,
                const CheckedImage& image,
                const FrameMeta& given) {
  RefuseWhenFull(intake);
  RigResolver resolver(OpenFlight(intake, frame.flight_id));
  const FrameMeta meta = KnownMeta(intake, frame.flight_id, given, image.tags.meta);
  // A frame with a timestamp may wait for telemetry to give its position.
  if (!meta.position && given.timestamp_us) {
    resolver.CheckSize(image);
  } else {
    resolver.Admit(image, meta);
  }
  intake.storage.images.Write(image.sha256, upload.image);
  try {
    intake.storage.frames.Insert(frame.flight_id, {frame}, std::nullopt, [&](FlightRow& flight) {
      RefuseWhenRetired(flight);
      // A stored rig is kept, because another request may have added a datum to it since it was
      // read.
      if (flight.rig_json.empty()) flight.rig_json = resolver.RigJson();
      flight.warnings_json =
          AddWarnings(flight.warnings_json, "images", resolver.RelevantWarnings(image));
      flight.warnings_json =
          AddWarnings(flight.warnings_json,
                      "images",
                      TimeWarnings({CaptureTimeOf(frame, Merged(given, image.tags.meta))},
                                   frame.arrived_at_us));
    });
  } catch (...) {
    // A refused image must not occupy a full disk.
    intake.storage.images.RemoveUnused(image.sha256);
    throw;
  }
}

}  // namespace

std::optional<FrameRow> SameFrame(const Intake& intake, const FrameRow& frame) {
  auto stored = intake.storage.frames.Find(frame.flight_id, frame.id);
  if (!stored) return std::nullopt;
  if (stored->sha256 != frame.sha256) {
    throw ApiError(
        "FrameConflict",
        "the frame is stored with the image " + stored->sha256 + ", not with " + frame.sha256);
  }
  if (stored->meta_json != frame.meta_json) {
    throw ApiError("FrameConflict", "the frame is stored with different meta");
  }
  return stored;
}

TakenFrame TakeFrame(Intake& intake,
                     const std::string& flight_id,
                     const std::string& frame_id,
                     const FrameUpload& upload) {
  // For a known id, SameFrame reports a differing image as a conflict, so the size is not checked.
  const bool is_known = intake.storage.frames.Find(flight_id, frame_id).has_value();
  const CheckedImage image = CheckImage(
      intake, upload.image, is_known ? std::nullopt : CameraOf(OpenFlight(intake, flight_id)));
  const FrameMeta given = ParseFrameMeta(upload.meta);
  if (given.timestamp_us) RefuseFutureTime(*given.timestamp_us, NowUs());
  const FrameRow frame = NewFrameRow(flight_id, frame_id, image.sha256, {given, image.tags.meta});
  {
    const std::lock_guard lock(intake.intake_mutex);
    if (const auto stored = SameFrame(intake, frame)) return {*stored, false};
    try {
      StoreFrame(intake, upload, frame, image, given);
    } catch (const StorageError& error) {
      // Another server may have stored it meanwhile.
      const auto stored =
          error.fault == StorageFault::kConflict ? SameFrame(intake, frame) : std::nullopt;
      if (!stored) throw;
      return {*stored, false};
    }
  }
  intake.events.Publish("frame", flight_id, FrameJson(frame).dump());
  intake.wake_worker();
  intake.on_new_pose(flight_id);
  return {frame, true};
}

void RefuseWhenFull(const Intake& intake) {
  const int64_t num_queued = intake.storage.frames.CountQueued();
  if (num_queued < intake.config.max_num_queued_frames) return;
  ApiError error("QueueFull", "too many frames wait for the engine");
  error.limit = static_cast<double>(intake.config.max_num_queued_frames);
  error.observed = static_cast<double>(num_queued);
  throw error;
}

nlohmann::json FrameJson(const FrameRow& frame) {
  nlohmann::json object{
      {"id", frame.id}, {"sha256", frame.sha256}, {"state", StateName(frame.state)}};
  if (!frame.reason.empty()) object["reason"] = frame.reason;
  const FrameMeta meta = ParseStoredPose(frame.resolved_json, frame.meta_json, frame.tags_json);
  object["pose"] = PoseJson(frame, meta);
  const CaptureTime time = CaptureTimeOf(frame, meta);
  object["timestamp_us"] = nullptr;
  object["time_source"] = nullptr;
  if (!time.source) return object;
  object["timestamp_us"] =
      time.source == TimeSource::kArrival ? frame.arrived_at_us : *meta.timestamp_us;
  object["time_source"] = NameOf(*time.source);
  return object;
}

}  // namespace freelsd
