// The mosaic of a recorded flight as files to look at, and what it costs and how good it is.
#pragma once

#include <string>
#include <vector>

#include "tests/evaluation/recorded/control_points.h"

namespace freelsd {

struct MosaicFigures {
  // Of the processor, with decoding, without writing the tiles.
  double seconds = 0.0;
  // Memory at its peak, above what was in use before.
  double peak_mb = 0.0;
  double shown_km2 = 0.0;
  double pixel_size_m = 0.0;
  int num_tiles = 0;
  double step_photographed = 0.0;
  double step_with_gains = 0.0;
  double step_blended = 0.0;
  // Gradient energy of the mosaic divided by that of the photographs at the same places: median.
  double sharpness_ratio = 0.0;
  // Of targets that the chosen photograph shows: distance between the place where the mosaic shows
  // them and the place where all photographs triangulate them, pixels of the mosaic.
  int num_targets = 0;
  double target_rms_px = 0.0;
  double target_largest_px = 0.0;
};

// Makes the mosaic from the files in the flight's folder `images/`. Writes into `output`: tiles,
// `overview.png`, and `seams.png`: 20 places on seams, beside each the same place with its seams.
MosaicFigures WriteMosaic(const RecordedFlight& flight,
                          const std::string& images,
                          const ElevationMap& map,
                          const std::vector<Sighting>& sightings,
                          const std::string& output);

}  // namespace freelsd
