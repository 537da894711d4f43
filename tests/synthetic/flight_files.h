// Input: a synthetic flight. Output: the texts that describe it, as the HTTP contract wants
// them.
#pragma once

#include <string>
#include <vector>

#include "engine/flight/flight.h"
#include "tests/synthetic/flight_plan.h"
#include "tests/synthetic/world.h"

namespace freelsd {

// The paper's down-looking camera for an image of that size: 465 px focal length at 752 px width.
Camera PaperCamera(int width_px, int height_px);
// Its own size, 752 x 480, straight down.
Rig PaperRig();

// `poses` of a batch: what the autopilot said.
std::string PosesCsv(const World& world, const std::vector<SyntheticExposure>& exposures);

// Body of POST /v1/flights.
std::string FlightJson(const std::string& name, const Camera& camera, const std::string& profile);

}  // namespace freelsd
