#include "engine/regions/regions.h"

#include <cmath>

#include "engine/check/check.h"
#include "engine/regions/region_update.h"

namespace freelsd {

void RegionsOptions::Check() const {
  const FieldCheck check("regions");
  check.Require(std::isfinite(min_area_m2) && min_area_m2 > 0.0,
                "min_area_m2",
                min_area_m2,
                "must be positive and finite");
  check.Require(min_num_observations_floor >= 2,
                "min_num_observations_floor",
                min_num_observations_floor,
                "must be at least 2");
  check.Require(min_num_observations >= min_num_observations_floor,
                "min_num_observations",
                min_num_observations,
                "must be at least min_num_observations_floor = " +
                    std::to_string(min_num_observations_floor));
  check.Inside("min_overlap_of_unlike_ratio", min_overlap_of_unlike_ratio, 0.0, 1.0);
  check.Inside("min_fixing_overlap_ratio", min_fixing_overlap_ratio, 0.0, 1.0);
  check.Require(max_num_regions >= 1, "max_num_regions", max_num_regions, "must be at least 1");
  check.Require(std::isfinite(border_margin_px) && border_margin_px >= 0.0,
                "border_margin_px",
                border_margin_px,
                "must be at least 0 and finite");
  check.Require(std::isfinite(max_viewing_distance_ratio) && max_viewing_distance_ratio > 1.0,
                "max_viewing_distance_ratio",
                max_viewing_distance_ratio,
                "must be greater than 1 and finite");
}

Polygon GroundPolygon(const std::vector<Eigen::Vector3d>& corners_in_world) {
  Polygon polygon;
  for (const Eigen::Vector3d& corner : corners_in_world) polygon.push_back(corner.head<2>());
  return polygon;
}

Polygon Region::Footprint() const { return GroundPolygon(corners_in_world); }

Eigen::Vector3d Region::Center() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& corner : corners_in_world) sum += corner;
  return corners_in_world.empty() ? sum : Eigen::Vector3d(sum / corners_in_world.size());
}

Regions::Regions(const RegionsOptions& options) {
  options.Check();
  state_ = std::make_unique<State>(options);
}

Regions::~Regions() = default;
Regions::Regions(Regions&&) noexcept = default;
Regions& Regions::operator=(Regions&&) noexcept = default;

std::vector<Region> Regions::Ranked() const { return state_->tracker.Ranked(); }

int Regions::MinNumObservations() const {
  return state_->overlap.MinNumObservations(state_->options);
}

}  // namespace freelsd
