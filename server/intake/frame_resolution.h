// Determines a frame's final metadata from three sources: the client, telemetry, the image's tags.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/api.h"
#include "server/intake/state.h"

namespace freelsd {

// Merges the metadata. Precedence: the client's metadata, then telemetry, then the image's tags.
FrameMeta KnownMeta(const Intake& intake,
                    const std::string& flight_id,
                    const FrameMeta& given,
                    const FrameMeta& tags);

// When the frame's photograph was taken. `meta` is merged.
CaptureTime CaptureTimeOf(const FrameRow& frame, const FrameMeta& meta);
// What is doubtful about the times of photographs that arrived together, for people.
std::vector<std::string> TimeWarnings(const std::vector<CaptureTime>& times, int64_t arrived_at_us);

// A frame's row with the pose that the engine uses, parsed once.
struct PosedFrame {
  // Parses the pose if the frame is resolved.
  explicit PosedFrame(FrameRow frame_row);

  FrameRow row;
  // Nothing if the frame is not resolved yet, or if it was rejected and never resolved.
  std::optional<FrameMeta> meta;
};

// State of a frame's metadata: final, waiting for telemetry, or unusable.
enum class Resolution { kReady, kWaiting, kRejected };

// Determines the metadata that the engine uses for a queued frame. The first frame with a position
// also determines the flight's rig. Metadata and rig are stored, so that a replay uses the same
// values. A frame without a position is kWaiting while `may_wait` is true, else kRejected. A frame
// is also rejected if it does not fit the flight's rig or is too far from the flight's origin.
Resolution ResolveFrame(Intake& intake, const FlightRow& flight, PosedFrame& posed, bool may_wait);

// Throws ApiError Conflict if the flight's images were removed.
void RefuseWhenRetired(const FlightRow& flight);

}  // namespace freelsd
