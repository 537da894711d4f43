// Input: a finished map, its layers, and one landing on it. Output: the probability that the
// landing fails, and its parts.
//
// A landing is a final and a ground roll. It fails if the aircraft meets something on the final
// that is no ground to land on, or if ground below the roll, from the first contact on, is not fit
// to land on. A contact with fit ground before the planned touchdown is a short landing.
#pragma once

#include <memory>
#include <optional>

#include "engine/hazard/hazard.h"

namespace freelsd {

// In error messages the fields are named `approach.…`.
struct RiskOptions {
  // Number of flights over which the touchdown, the map's shift and tilt and the wind are averaged.
  // They are points of a Halton sequence, so the same landing always gets the same number.
  int num_risk_flights = 128;
  // Errors of the map's heights and classes within this distance along the path are one error.
  // Source: calibration on
  // tuning worlds (`freelsd-eval`, section "landings drawn at random").
  double error_length_m = 10.0;
  // Standard deviation of the wind, per axis, where it was not measured.
  double unmeasured_wind_sd_mps = 0.5;

  void Check() const;
};

// What is probably wrong with a cell of the map.
struct CellRisk {
  // Probability that the ground is not fit to land on because of what grows there: 1 - posterior of
  // grass; 1 where unknown.
  double kind = 1.0;
  // The same because of the shape of the ground or of something on it.
  double shape = 1.0;
  // Highest point, world z, and its standard deviation.
  double top = 0.0;
  double top_sd = 0.0;
};
// Nothing where the cell is kUnseen.
std::optional<CellRisk> RiskOfCell(const ElevationMap& map,
                                   const HazardLayers& layers,
                                   const Aircraft& aircraft,
                                   const cv::Point& cell);

// The largest of slope, roughness and height of an object in a seen cell, each as a share of its
// limit.
double ShapeRatio(const ElevationMap& map,
                  const HazardLayers& layers,
                  const Aircraft& aircraft,
                  const cv::Point& cell);
// Probability that ground with this ratio is not fit to land on because of its shape.
double RiskOfShape(double shape_ratio);

// A straight final, the ground roll after it, and the circle before it.
struct PlannedLanding {
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  // Direction of travel, radians clockwise from north.
  double heading = 0.0;
  double approach_distance = 0.0;
  double approach_height = 0.0;
  // Ground speed on final, m/s, in the planned wind.
  double ground_speed = 0.0;
  // Deviation of the wind per axis; 0 if it was not measured.
  double wind_spread_mps = 0.0;
  // Deviation of the map's position along one axis.
  double position_sd_m = 0.0;
  Eigen::Vector2d loiter_center_in_world = Eigen::Vector2d::Zero();
  double loiter_radius = 0.0;
};

// The parts do not add up: one flight may fail by several of them, and position and wind act
// through the others.
struct FailureParts {
  // The ground below the roll; something on the final; something below the circle. Each as if it
  // were the only one.
  double ground = 0.0;
  double final_path = 0.0;
  double circle = 0.0;
  // What an exactly known map position and tilt, or an exactly known wind, would take off.
  double position = 0.0;
  double wind = 0.0;
};

struct LandingRisk {
  // Over what was seen. Unseen cells do not count here: the planner asks for them separately.
  double failure_probability = 1.0;
  FailureParts parts;
};

// Assesses landings on one map. Thread-safe. Map and layers must outlive it.
class RiskAssessor {
 public:
  // Throws std::invalid_argument if the options are invalid.
  RiskAssessor(const ElevationMap& map,
               const HazardLayers& layers,
               const Aircraft& aircraft,
               const RiskOptions& options);
  ~RiskAssessor();

  // 1 if the deviation of the map's position or tilt is unknown.
  double FailureProbability(const PlannedLanding& landing) const;
  // The same probability, with its parts; takes three times as long.
  LandingRisk Assess(const PlannedLanding& landing) const;

 private:
  struct State;
  std::unique_ptr<const State> state_;
};

}  // namespace freelsd
