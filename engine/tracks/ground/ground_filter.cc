#include <algorithm>
#include <cmath>

#include "engine/tracks/ground/ground.h"

namespace freelsd {
namespace {

// Standard deviation of a terrain's height difference per metre of distance: hilly pasture.
constexpr double kTerrainSlope = 0.05;
// Lower bound: landmarks of one frame share errors, and a given height is rounded.
constexpr double kMinSdM = 1.0;

}  // namespace

void GroundFilter::MoveTo(const Eigen::Vector3d& position_in_world) {
  const Eigen::Vector2d place = position_in_world.head<2>();
  if (place_) variance_ += std::pow(kTerrainSlope * (place - *place_).norm(), 2);
  place_ = place;
}

void GroundFilter::Update(const GroundHeight& measured) {
  const double measured_variance = std::pow(std::max(measured.sd_m, kMinSdM), 2);
  if (!height_) {
    height_ = measured.z;
    variance_ = measured_variance;
    return;
  }
  const double gain = variance_ / (variance_ + measured_variance);
  *height_ += gain * (measured.z - *height_);
  variance_ = std::max((1.0 - gain) * variance_, kMinSdM * kMinSdM);
}

void GroundFilter::Restart(const Eigen::Vector3d& position_in_world, double ground_height) {
  height_ = ground_height;
  variance_ = kMinSdM * kMinSdM;
  place_ = position_in_world.head<2>();
}

double GroundFilter::Sd() const { return std::sqrt(variance_); }

}  // namespace freelsd
