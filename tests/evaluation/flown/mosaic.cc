#include "tests/evaluation/flown/mosaic.h"

#include <iostream>
#include <limits>
#include <utility>

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

Scenario MakeMosaicPart(uint64_t first_seed, int side, int i, const ScenarioOptions& options) {
  ScenarioOptions part = options;
  const int row = i / side;
  part.east_m = (i % side - 0.5 * (side - 1)) * part.world_size_m;
  part.north_m = (row - 0.5 * (side - 1)) * part.world_size_m;
  std::cerr << "world " << i + 1 << " of " << side * side << std::endl;
  return MakeScenario(first_seed + static_cast<uint64_t>(i), part, [](double) {});
}

Mosaic MakeMosaic(uint64_t first_seed, int side) {
  Mosaic mosaic;
  ScenarioOptions options;
  options.takes_photographs = false;
  options.aircraft = "small";
  for (int i = 0; i < side * side; ++i) {
    mosaic.Add(MakeMosaicPart(first_seed, side, i, options).world);
  }
  return mosaic;
}

}  // namespace freelsd
