// Reads the stored photographs of a flight.
#pragma once

#include <string>

#include "engine/flight/flight.h"
#include "server/intake/state.h"
#include "storage/storage.h"

namespace freelsd {

// The decoded image of a frame; empty if its file is missing. Throws std::runtime_error that names
// the photograph if the image cannot be read or decoded.
cv::Mat StoredImage(const Intake& intake, const FrameRow& frame);
// The same by id; empty also if there is no such frame. `intake` must outlive it.
ImageSource StoredImages(const Intake& intake, const std::string& flight_id);

}  // namespace freelsd
