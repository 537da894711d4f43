#include "tests/evaluation/flown/mosaic.h"

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

}  // namespace freelsd
