// Private to terrain/. Shape of the ground: slope and roughness of an elevation raster.
#pragma once

#include <array>

#include "engine/terrain/terrain.h"

namespace freelsd {

// Elevation; NaN where it is unseen or its deviation exceeds the limit.
cv::Mat1f TrustedElevation(const ElevationMap& map, double max_standard_deviation_m);

// Radians; NaN if the cell or too many cells of its support are unseen.
cv::Mat1f PlaneSlope(const cv::Mat1f& elevation, double cell_size_m, const SurfaceOptions& options);
cv::Mat1f PaperPcaSlope(const cv::Mat1f& elevation,
                        double cell_size_m,
                        const SurfaceOptions& options);

// Angle between the vertical and the normal, in radians, by PCA of nine cells in closed form.
// Heights are in metres, row by row; only their differences matter.
double PcaSlopeOf(const std::array<double, 9>& heights, double cell_size_m);

// Riley et al. 1999, with neighbours `spacing` cells away. NaN if any of the nine cells is unseen.
cv::Mat1f Ruggedness(const cv::Mat1f& elevation, int spacing);

}  // namespace freelsd
