// Input: what a client sends. Output: the data types of a flight: Frame, Rig, Aircraft,
// StageReport.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {

// Aircraft pose from the autopilot (or a geotag) at the time of exposure. Typical errors are a few
// metres and a few degrees. The altitude may be biased.
struct PosePrior {
  // Body origin, world frame, metres.
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  double position_sd_m = 2.0;
  // Unknown for plain geotags. The ground track does not give the heading: in wind, the two may
  // differ by up to 60 deg for a small plane.
  std::optional<Eigen::Quaterniond> world_from_body;
  double attitude_sd_deg = 2.0;
};

struct Frame {
  std::string id;
  // Microseconds since 1970. If the time is unknown, it is the frame's number in the order of
  // arrival.
  int64_t timestamp_us = 0;
  // 8 bit, BGR or grey, as the sensor delivered it: EXIF orientation is not applied, because the
  // intrinsics refer to the sensor's axes.
  cv::Mat image;
  PosePrior prior;
  // Velocity of the air, east-north, m/s; points to where the air moves.
  std::optional<Eigen::Vector2d> wind_in_world;
  std::optional<double> height_above_ground;
};

// Loads a frame's image by its id, because the engine keeps no full-size images. Returns an empty
// image if it is unavailable. Several threads call it at once.
using ImageSource = std::function<cv::Mat(const std::string& frame_id)>;

// Camera and its mounting, constant during a flight.
struct Rig {
  Camera camera;
  // Default: looking straight down, image top towards the nose (camera x = body right, camera y =
  // body aft, camera z = body down).
  Rigid3d body_from_camera{Eigen::Quaterniond(0.70710678118654757, 0.0, 0.0, 0.70710678118654757),
                           Eigen::Vector3d::Zero()};
};

// Capabilities and needs of the aircraft. The fields are those of api/openapi.yaml. Paper: Eq. 1,
// Sec. III-H.
struct Aircraft {
  std::string profile = "techpod";
  // Airspeed on final. Paper: v_land, 13 m/s.
  double landing_airspeed_mps = 13.0;
  // Angle of descent on final. Paper: gamma_land, 4 deg.
  double flight_path_angle_deg = 4.0;
  // Bank in the loiter-down circle. Paper: phi_land, 11 deg.
  double max_bank_deg = 11.0;
  // Height of the circle and of the start of the final above touchdown. Paper: h_app, 12 m.
  double approach_height_m = 12.0;
  // Largest difference between true and estimated wind direction. Paper: Delta beta_w, 30 deg.
  double crosswind_uncertainty_deg = 30.0;
  // Radius of the disc in which the aircraft may touch down. Paper: Delta_TD, 10 m.
  double touchdown_uncertainty_m = 10.0;
  // Distance per height lost without power, in still air, at glide_airspeed_mps.
  double glide_ratio = 12.0;
  // Airspeed of the glide. If empty, the aircraft glides at the landing airspeed.
  std::optional<double> glide_airspeed_mps;
  // Ground that exceeds one of these limits is a hazard.
  double max_slope_deg = 8.0;
  double max_roughness_m = 0.5;
  // The path must have this clearance above the map's upper surface. It is checked in a corridor
  // with this half-width.
  double safety_margin_m = 2.0;
  double path_half_width_m = 5.0;
  // Least ground speed on a final straight into the wind. Below it, gusts could stop the aircraft.
  double min_ground_speed_mps = 3.0;
  // Angle of a full-power climb at the landing airspeed in still air, for the go-around.
  double climb_gradient_deg = 5.0;
  // Length of the strip that must be free for the ground roll. It extends from the touchdown point
  // in the landing direction. Paper: 0, only the disc.
  double ground_roll_m = 30.0;
  // Largest probability that a landing fails (LandingRisk). Not in the paper.
  double max_failure_probability = 0.1;
  // Smallest region to evaluate. Paper: A_min.
  double min_area_m2 = 900.0;

  // Throws std::invalid_argument: "aircraft.max_bank_deg = 95: must be in [1, 80]".
  void Check() const;
};

// "techpod", "atlantiksolar" or "small"; nothing for another name.
std::optional<Aircraft> AircraftProfile(std::string_view name);
std::vector<std::string> AircraftProfileNames();
// Describes each limit of the aircraft that is looser than in every profile. Example:
// "max_slope_deg = 60 (profiles: at most 8)".
std::vector<std::string> LimitsLooserThanProfiles(const Aircraft& aircraft);

// Cost and result of one run of a stage. The engine does not log; the server logs these reports.
struct StageReport {
  std::string stage;
  double seconds = 0.0;
  int64_t count = 0;
  std::string note;
};

}  // namespace freelsd
