#include "engine/regions/regions.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "engine/regions/region_update.h"

namespace freelsd {
namespace {

void Require(bool holds, const std::string& field, double value, const std::string& constraint) {
  if (holds) return;
  throw std::invalid_argument("regions." + field + " = " + std::to_string(value) + ": " +
                              constraint);
}

}  // namespace

void RegionsOptions::Check() const {
  Require(min_area_m2 > 0.0, "min_area_m2", min_area_m2, "must be positive");
  Require(min_num_observations >= 2, "min_num_observations", min_num_observations, "must be >= 2");
  Require(min_num_observations_floor >= 2,
          "min_num_observations_floor",
          min_num_observations_floor,
          "must be >= 2");
  Require(max_num_regions >= 1, "max_num_regions", max_num_regions, "must be >= 1");
  Require(border_margin_px >= 0.0, "border_margin_px", border_margin_px, "must be >= 0");
}

Polygon Region::Footprint() const {
  Polygon polygon;
  for (const Eigen::Vector3d& corner : corners_in_world) polygon.push_back(corner.head<2>());
  return polygon;
}

Eigen::Vector3d Region::Center() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& corner : corners_in_world) sum += corner;
  return corners_in_world.empty() ? sum : Eigen::Vector3d(sum / double(corners_in_world.size()));
}

Regions::Regions(const RegionsOptions& options)
    : options_(options), min_num_observations_(options.min_num_observations) {
  options_.Check();
}

std::vector<Region> Regions::Ranked() const {
  std::vector<Region> ranked;
  for (const TrackedRegion& tracked : regions_) ranked.push_back(tracked.region);
  std::sort(ranked.begin(), ranked.end(), [](const Region& a, const Region& b) {
    if (a.grade != b.grade) return a.grade > b.grade;
    if (a.num_observations != b.num_observations) return a.num_observations > b.num_observations;
    return a.id < b.id;
  });
  return ranked;
}

int Regions::MinNumObservations() const { return min_num_observations_; }

}  // namespace freelsd
