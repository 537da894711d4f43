// Ground scale of the photographs of unseen places: a CSV file with the columns place,
// photograph_prefix, ground_sampling_m and source.
#pragma once

#include <string>
#include <vector>

namespace freelsd {

struct PlaceCamera {
  std::string place;
  // Beginning of the file names. Empty: every photograph of the place.
  std::string photograph_prefix;
  // Metres on the ground per pixel of the stored photograph.
  double ground_sampling_m = 0.0;
  // How the scale was measured.
  std::string source;
};

// Throws std::runtime_error that names file and line.
std::vector<PlaceCamera> ReadPlaceCameras(const std::string& path);

// The camera with the longest prefix that fits. Throws std::runtime_error if none fits.
const PlaceCamera& CameraOf(const std::string& place,
                            const std::string& photograph,
                            const std::vector<PlaceCamera>& cameras);

}  // namespace freelsd
