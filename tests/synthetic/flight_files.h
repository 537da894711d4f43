// Input: a synthetic flight. Output: the texts that describe it, as the HTTP contract wants them,
// and its truth.
#pragma once

#include <string>
#include <vector>

#include "engine/flight/flight.h"
#include "tests/synthetic/flight_plan.h"
#include "tests/synthetic/truth.h"
#include "tests/synthetic/world.h"

namespace freelsd {

// The paper's down-looking camera for an image of that size: 465 px focal length at 752 px width.
Camera PaperCamera(int width_px, int height_px);

// "paper": the same, 752 x 480, straight down. "oblique": 1600 x 1200, tilted towards the nose.
// "wide": 12 megapixels behind a wide lens that distorts, straight down. Throws
// std::invalid_argument on other names.
Rig SyntheticRig(const std::string& name);

// `poses` of a batch: what the autopilot said.
std::string PosesCsv(const World& world, const std::vector<SyntheticExposure>& exposures);

// Body of POST /v1/flights.
std::string FlightJson(const std::string& name, const Camera& camera, const std::string& profile);

// Everything the evaluation needs to judge an answer. Outlines and places as [longitude, latitude].
std::string TruthJson(const World& world,
                      const std::vector<TrueField>& fields,
                      const std::vector<SyntheticExposure>& exposures,
                      const Aircraft& aircraft);

}  // namespace freelsd
