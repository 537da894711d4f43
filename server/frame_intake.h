// One frame, however it came: checked, stored, told of.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "server/service.h"

namespace freelsd {

struct FrameUpload {
  std::string image;
  std::string meta = "{}";
};

struct TakenFrame {
  FrameRow frame;
  // False: it was stored before, with the same image and meta.
  bool is_new = true;
};

// Durable when it returns. Throws ApiError; nothing has changed then.
TakenFrame TakeFrame(Service& service,
                     const std::string& flight_id,
                     const std::string& frame_id,
                     const FrameUpload& upload);

// Throws ApiError QueueFull where the engine is behind.
void RefuseWhenFull(const Service& service);

// {id, sha256, state, reason?}.
nlohmann::json FrameJson(const FrameRow& frame);

}  // namespace freelsd
