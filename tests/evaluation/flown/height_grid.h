// The true surface of a mosaic as a file, for simulators that know nothing of worlds.
#pragma once

#include <filesystem>

#include "tests/evaluation/flown/mosaic.h"

namespace freelsd {

// `path`.json: {latitude_deg, longitude_deg: of the first cell's centre, latitude_step_deg,
// longitude_step_deg, num_rows, num_cols, lowest_ground_m}. `path`.f32: altitudes of the highest
// thing at each cell's centre, metres, little-endian floats; row 0 is the southern edge.
// `cell_size_m` is rounded. Throws std::runtime_error if a file cannot be written.
void WriteHeightGrid(const Mosaic& mosaic, double cell_size_m, const std::filesystem::path& path);

}  // namespace freelsd
