// Input: a source of images for one thread. Output: the same source for several threads.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "engine/flight/flight.h"

namespace freelsd {

// Threads wait for each other, because a source may keep what it read last. `images` must outlive
// the result.
inline ImageSource OneAtATime(const ImageSource& images) {
  // Guards `images`.
  const auto mutex = std::make_shared<std::mutex>();
  return [&images, mutex](const std::string& frame_id) {
    const std::lock_guard<std::mutex> lock(*mutex);
    return images(frame_id);
  };
}

}  // namespace freelsd
