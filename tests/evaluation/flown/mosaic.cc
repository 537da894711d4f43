#include "tests/evaluation/flown/mosaic.h"

#include <iostream>
#include <limits>
#include <utility>

#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {

void Mosaic::Add(World world) {
  world.variant.release();
  world.albedo.release();
  world.radiance.release();
  world.photographed.release();
  world.is_textured.release();
  frames_.emplace_back(world.origin);
  worlds_.push_back(std::move(world));
}

MosaicPlace Mosaic::PlaceOf(const GeoPoint& place) const {
  MosaicPlace nearest;
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < worlds_.size(); ++i) {
    const Eigen::Vector3d in_world = frames_[i].WorldFromGeo(place);
    const double distance = in_world.head<2>().cwiseAbs().maxCoeff();
    if (distance >= least) continue;
    least = distance;
    nearest = {&worlds_[i], in_world};
  }
  return nearest;
}

Mosaic MakeMosaic(uint64_t first_seed, int side) {
  Mosaic mosaic;
  ScenarioOptions options;
  options.takes_photographs = false;
  options.aircraft = "small";
  for (int i = 0; i < side * side; ++i) {
    options.east_m = (i % side - 0.5 * (side - 1)) * options.world_size_m;
    const int row = i / side;
    options.north_m = (row - 0.5 * (side - 1)) * options.world_size_m;
    const uint64_t seed = first_seed + static_cast<uint64_t>(i);
    mosaic.Add(MakeScenario(seed, options, [](double) {}).world);
    std::cerr << "\rworld " << i + 1 << std::flush;
  }
  std::cerr << "\n";
  return mosaic;
}

}  // namespace freelsd
