// Settles a frame's metadata from its three sources: the client, telemetry, the image's tags.
#pragma once

#include <optional>
#include <string>

#include "api/api.h"
#include "server/intake/state.h"

namespace freelsd {

// Merged metadata: the client's overrides telemetry's, and telemetry's overrides the image's tags.
FrameMeta KnownMeta(const Intake& intake,
                    const std::string& flight_id,
                    const FrameMeta& given,
                    const FrameMeta& tags);

// A frame's row with its pose as the engine takes it, parsed once.
struct PosedFrame {
  // Reads the pose if the row is resolved.
  explicit PosedFrame(FrameRow frame_row);

  FrameRow row;
  // Unknown before the frame is resolved, and for a frame that was rejected without a position.
  std::optional<FrameMeta> meta;
};

// The state of a frame's metadata: settled, waiting for telemetry, or impossible to settle.
enum class Resolution { kReady, kWaiting, kRejected };

// Settles the metadata that the engine uses for a queued frame; the first frame with a position
// also settles the flight's rig. Stores both, so that a replay uses the same values. A frame
// without a position is kWaiting while `may_wait`, then kRejected.
Resolution ResolveFrame(Intake& intake, const FlightRow& flight, PosedFrame& posed, bool may_wait);

// Throws ApiError Conflict if the flight's images were removed.
void RefuseWhenRetired(const FlightRow& flight);

}  // namespace freelsd
