// Reads the stored photographs of a flight.
#pragma once

#include <string>

#include "engine/flight/flight.h"
#include "server/intake/state.h"

namespace freelsd {

// Reads and decodes the image of a frame; empty if there is no such frame, or if its file is
// missing. `intake` must outlive it. Throws ApiError on an image that cannot be decoded.
ImageSource StoredImages(const Intake& intake, const std::string& flight_id);

}  // namespace freelsd
