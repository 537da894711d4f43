#include "server/frame_intake.h"

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/frame_resolution.h"
#include "server/intake.h"
#include "server/warnings.h"

namespace freelsd {
namespace {

const char* StateName(FrameState state) {
  constexpr const char* kNames[] = {"queued", "processed", "rejected"};
  return kNames[static_cast<int>(state)];
}

// The stored frame when it is the same; nothing when there is none. Throws FrameConflict.
std::optional<FrameRow> SameFrame(const Service& service, const FrameRow& frame) {
  const auto stored = service.storage.FindFrame(frame.flight_id, frame.id);
  if (!stored) return std::nullopt;
  if (stored->sha256 != frame.sha256) {
    throw ApiError(
        "FrameConflict",
        "the frame is stored with the image " + stored->sha256 + ", not with " + frame.sha256);
  }
  if (stored->meta_json != frame.meta_json) {
    throw ApiError("FrameConflict", "the frame is stored with another meta");
  }
  return stored;
}

FlightRow OpenFlight(const Service& service, const std::string& flight_id) {
  const std::optional<FlightRow> flight = service.storage.FindFlight(flight_id);
  if (!flight) throw ApiError("NoSuchFlight", "there is no such flight");
  RefuseWhenRetired(*flight);
  return *flight;
}

void StoreFrame(Service& service,
                const FrameUpload& upload,
                const FrameRow& frame,
                const CheckedImage& image,
                const FrameMeta& given) {
  RefuseWhenFull(service);
  RigResolver resolver(OpenFlight(service, frame.flight_id));
  const FrameMeta meta = KnownMeta(service, frame.flight_id, given, image.tags.meta);
  // What has a time may wait for telemetry to tell where it was.
  if (!meta.position && given.timestamp_us) {
    resolver.CheckSize(image);
  } else {
    resolver.Admit(image, meta);
  }
  service.storage.WriteImage(image.sha256, upload.image);
  try {
    service.storage.InsertFrames(frame.flight_id, {frame}, std::nullopt, [&](FlightRow& flight) {
      flight.rig_json = resolver.RigJson();
      flight.warnings_json =
          AddWarnings(flight.warnings_json, "images", resolver.RelevantWarnings(image));
    });
  } catch (const StorageError&) {
    // A disk that is full must not keep what was refused.
    service.storage.RemoveUnusedImage(image.sha256);
    throw;
  }
}

}  // namespace

TakenFrame TakeFrame(Service& service,
                     const std::string& flight_id,
                     const std::string& frame_id,
                     const FrameUpload& upload) {
  // Under an id that is known, what the image is decides between a conflict and damage.
  const bool is_known = service.storage.FindFrame(flight_id, frame_id).has_value();
  const CheckedImage image = CheckImage(
      service, upload.image, is_known ? std::nullopt : CameraOf(OpenFlight(service, flight_id)));
  const FrameMeta given = ParseFrameMeta(upload.meta);
  const FrameRow frame = NewFrameRow(flight_id, frame_id, image, given);
  {
    const std::lock_guard lock(service.intake_mutex);
    if (const auto stored = SameFrame(service, frame)) return {*stored, false};
    StoreFrame(service, upload, frame, image, given);
  }
  service.events.Publish("frame", flight_id, FrameJson(frame).dump());
  service.wake_worker();
  service.alternates.Wake(flight_id);
  return {frame, true};
}

void RefuseWhenFull(const Service& service) {
  const int64_t num_queued = service.storage.CountQueuedFrames();
  if (num_queued < service.config.max_num_queued_frames) return;
  ApiError error("QueueFull", "too many frames wait for the engine");
  error.limit = static_cast<double>(service.config.max_num_queued_frames);
  error.observed = static_cast<double>(num_queued);
  throw error;
}

nlohmann::json FrameJson(const FrameRow& frame) {
  nlohmann::json object{
      {"id", frame.id}, {"sha256", frame.sha256}, {"state", StateName(frame.state)}};
  if (!frame.reason.empty()) object["reason"] = frame.reason;
  return object;
}

}  // namespace freelsd
