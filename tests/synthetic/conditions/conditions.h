// Input: a seed. Output: light, air, camera and file of one flight, as recorded flights show them.
#pragma once

#include <cstdint>

#include "tests/synthetic/renderer.h"
#include "tests/synthetic/world.h"

namespace freelsd {

struct Conditions {
  RenderOptions camera;
  int jpeg_quality = 92;
  // Of the sun; NaN: as the world has it.
  double sun_elevation_deg = 0.0;
  // World::sky_share.
  double sky_share = 0.36;
  // Deviation of the camera's turning about each axis, degrees per second.
  double turn_rate_deg_s = 0.0;
};

// A steady camera on a clear day.
Conditions PlainConditions(uint64_t seed);
// Drawn by the seed: sun (a fifth each low or behind clouds), exposure steps, vignetting, colour
// cast, haze, blur, rolling shutter, two JPEG qualities. README.md has the ranges
// and what was measured.
Conditions RecordedConditions(uint64_t seed);

// Moves the sun and the clouds, and lights the world anew.
void LightFor(const Conditions& conditions, World& world);

}  // namespace freelsd
