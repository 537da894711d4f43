// Private to hazard/. Shape of the ground: slope and roughness of an elevation raster.
#pragma once

#include "engine/hazard/hazard.h"

namespace freelsd {

// Elevation with NaN where it is unseen or its deviation is too large to be believed.
cv::Mat1f TrustedElevation(const ElevationMap& map, double max_standard_deviation_m);

// Radians; NaN where the cell or too much of its support is unseen.
cv::Mat1f PlaneSlope(const cv::Mat1f& elevation, double cell_size_m, const HazardOptions& options);
cv::Mat1f PaperPcaSlope(const cv::Mat1f& elevation,
                        double cell_size_m,
                        const HazardOptions& options);

// Riley et al. 1999, neighbours `spacing` cells away; NaN unless all of the nine are seen.
cv::Mat1f Ruggedness(const cv::Mat1f& elevation, int spacing);

}  // namespace freelsd
