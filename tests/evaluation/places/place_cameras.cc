#include "tests/evaluation/places/place_cameras.h"

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace freelsd {

std::vector<PlaceCamera> ReadPlaceCameras(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::vector<PlaceCamera> cameras;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.empty() || line.front() == '#' || line.starts_with("place,")) continue;
    std::istringstream cells(line);
    PlaceCamera camera;
    char comma = 0;
    std::getline(cells, camera.place, ',');
    std::getline(cells, camera.photograph_prefix, ',');
    const bool is_read = static_cast<bool>(cells >> camera.ground_sampling_m >> comma);
    std::getline(cells, camera.source);
    if (!is_read || comma != ',' || !(camera.ground_sampling_m > 0.0) || camera.source.empty()) {
      throw std::runtime_error(path + ":" + std::to_string(number) +
                               ": needs place,photograph_prefix,ground_sampling_m,source");
    }
    cameras.push_back(camera);
  }
  return cameras;
}

const PlaceCamera& CameraOf(const std::string& place,
                            const std::string& photograph,
                            const std::vector<PlaceCamera>& cameras) {
  const PlaceCamera* best = nullptr;
  for (const PlaceCamera& camera : cameras) {
    if (camera.place != place || !photograph.starts_with(camera.photograph_prefix)) continue;
    const bool is_longer =
        best == nullptr || camera.photograph_prefix.size() > best->photograph_prefix.size();
    if (is_longer) best = &camera;
  }
  if (best == nullptr) {
    throw std::runtime_error("no camera for the photograph " + place + "/" + photograph);
  }
  return *best;
}

}  // namespace freelsd
