// Accepts one frame: checks it, stores it, publishes an event.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "server/intake/state.h"

namespace freelsd {

// A frame as a client sends it: the encoded image and its metadata as JSON.
struct FrameUpload {
  std::string image;
  std::string meta = "{}";
};

// A stored frame.
struct TakenFrame {
  FrameRow frame;
  // False if the frame was already stored with the same image and meta.
  bool is_new = true;
};

// The stored frame with the id of `frame`; nothing if there is none. Throws ApiError FrameConflict
// if its image or meta differ.
std::optional<FrameRow> SameFrame(const Intake& intake, const FrameRow& frame);

// When it returns, the frame is on disk. If it throws ApiError, nothing was stored.
TakenFrame TakeFrame(Intake& intake,
                     const std::string& flight_id,
                     const std::string& frame_id,
                     const FrameUpload& upload);

// Throws ApiError QueueFull if too many frames wait for the engine.
void RefuseWhenFull(const Intake& intake);

// {id, sha256, state, reason?, timestamp_us, time_source}.
nlohmann::json FrameJson(const FrameRow& frame);

}  // namespace freelsd
