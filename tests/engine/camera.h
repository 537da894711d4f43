// A camera without distortion.
#pragma once

#include "engine/geometry/geometry.h"

namespace freelsd {

// It looks through the middle of its image.
inline Camera CenteredCamera(int width_px, int height_px, double focal_px) {
  Camera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 0.5 * (width_px - 1);
  camera.cy_px = 0.5 * (height_px - 1);
  return camera;
}

}  // namespace freelsd
