// Input: none. Output: geometric types: transforms, cameras, frames, polygons, rays.
//
// Frames:
//   world   local east-north-up, metres, tangent at the flight's origin (WGS84)
//   body    forward-right-down, as autopilots use it
//   camera  x right, y down, z along the optical axis (OpenCV)
//   image   pixels, (0, 0) is the centre of the top-left pixel
// Transforms are named target_from_source: x_in_target = target_from_source * x_in_source.
#pragma once

#include "engine/geometry/box_mean.h"
#include "engine/geometry/camera.h"
#include "engine/geometry/local_frame.h"
#include "engine/geometry/polygon.h"
#include "engine/geometry/processor_targets.h"
#include "engine/geometry/remap_table.h"
#include "engine/geometry/rigid3.h"
#include "engine/geometry/triangulation.h"
