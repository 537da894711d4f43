// Flights over a plane with texture, with their truth, for the tests of tracks/.
#pragma once

#include <algorithm>
#include <map>
#include <random>
#include <string>

#include "tests/engine/tracks/textured_plane.h"

namespace freelsd {

struct Noise {
  double position_sd_m = 0.0;
  double attitude_sd_deg = 0.0;
};

// Frames over the plane, with the truth beside them.
class SyntheticFlight {
 public:
  SyntheticFlight(const Rig& rig, double half_width_m) : rig_(rig), plane_(half_width_m) {}

  Frame Expose(const Eigen::Vector3d& position, const EulerAngles& attitude, const Noise& noise) {
    const Rigid3d world_from_camera = WorldFromCamera(rig_, position, attitude);
    Frame frame;
    frame.id = "frame_" + std::to_string(truth_.size());
    frame.timestamp_us = static_cast<int64_t>(truth_.size()) * 250000;
    frame.image = plane_.Photograph(rig_.camera, world_from_camera);
    frame.prior.position_in_world = position + noise.position_sd_m * Random3();
    frame.prior.position_sd_m = std::max(noise.position_sd_m, 0.3);
    const Eigen::Vector3d turn = RadFromDeg(noise.attitude_sd_deg) * Random3();
    frame.prior.world_from_body =
        WorldFromNed() *
        NedFromBody({attitude.roll + turn.x(), attitude.pitch + turn.y(), attitude.yaw + turn.z()});
    frame.prior.attitude_sd_deg = std::max(noise.attitude_sd_deg, 0.3);
    truth_[frame.id] = world_from_camera;
    return frame;
  }
  const Rigid3d& TruthOf(const std::string& frame_id) const { return truth_.at(frame_id); }
  Eigen::Vector3d Random3() {
    return {normal_(generator_), normal_(generator_), normal_(generator_)};
  }

 private:
  Rig rig_;
  TexturedPlane plane_;
  std::map<std::string, Rigid3d> truth_;
  std::mt19937 generator_{11};
  std::normal_distribution<double> normal_;
};

}  // namespace freelsd
