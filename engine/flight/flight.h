// Input: what a client sends. Output: the vocabulary of a flight: Frame, Aircraft, StageReport.
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

// Aircraft pose from the autopilot (or a geotag) at the time of exposure. Noisy: metres, degrees.
// The altitude may be biased.
struct PosePrior {
  // Body origin, world frame, metres.
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  double position_sd_m = 2.0;
  // world_from_body; unknown for plain geotags. The ground track is not the heading: small planes
  // crab up to 60 deg.
  std::optional<Eigen::Quaterniond> world_from_body;
  double attitude_sd_deg = 2.0;
};

struct Frame {
  std::string id;
  // Microseconds since 1970. If the time is unknown: the frame's number in order of arrival.
  int64_t timestamp_us = 0;
  // 8 bit, BGR or grey, as the sensor delivered it: EXIF orientation is not applied, intrinsics
  // belong to the sensor.
  cv::Mat image;
  PosePrior prior;
  // Direction and speed of the moving air, east-north, m/s.
  std::optional<Eigen::Vector2d> wind_in_world;
  std::optional<double> height_above_ground;
};

// Loads a frame's image by its id: the engine keeps no full-size images. Empty if unavailable.
using ImageSource = std::function<cv::Mat(const std::string& frame_id)>;

// Constant during a flight.
struct Rig {
  Camera camera;
  // Default: looking straight down, image top towards the nose (camera x = body right, camera y =
  // body aft, camera z = body down).
  Rigid3d body_from_camera{Eigen::Quaterniond(0.70710678118654757, 0.0, 0.0, 0.70710678118654757),
                           Eigen::Vector3d::Zero()};
};

// Capabilities and needs of the aircraft. Fields as in api/openapi.yaml; paper: Eq. 1, Sec. III-H.
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
  // Largest turn of the wind from its estimate. Paper: Delta beta_w, 30 deg.
  double crosswind_uncertainty_deg = 30.0;
  // Radius of the disc in which the aircraft may touch down. Paper: Delta_TD, 10 m.
  double touchdown_uncertainty_m = 10.0;
  // Distance per height without power, in still air, at glide_airspeed_mps.
  double glide_ratio = 12.0;
  // Default: the landing airspeed.
  std::optional<double> glide_airspeed_mps;
  // Limits of the binary hazard layers.
  double max_slope_deg = 8.0;
  double max_roughness_m = 0.5;
  // Clearance to keep above the map's upper surface, and half-width of the corridor to check.
  double safety_margin_m = 2.0;
  double path_half_width_m = 5.0;
  // Least ground speed on final, with the whole wind against it. Slower, gusts stop the aircraft.
  double min_ground_speed_mps = 3.0;
  // Length of the strip behind touchdown that must be free; 0 is the paper's rule.
  double ground_roll_m = 30.0;
  // Smallest region to evaluate. Paper: A_min.
  double min_area_m2 = 900.0;

  // Throws std::invalid_argument: "aircraft.max_bank_deg = 95: must be in [1, 80]".
  void Check() const;
};

// "techpod", "atlantiksolar" or "small"; nothing for another name.
std::optional<Aircraft> AircraftProfile(std::string_view name);
std::vector<std::string> AircraftProfileNames();
// Limits looser than those of every profile: "max_slope_deg = 60 (profiles: at most 8)".
std::vector<std::string> LimitsLooserThanProfiles(const Aircraft& aircraft);

// Cost and result of one run of a stage. The engine does not log: the server does.
struct StageReport {
  std::string stage;
  double seconds = 0.0;
  int64_t count = 0;
  std::string note;
};

}  // namespace freelsd
