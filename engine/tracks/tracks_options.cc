#include <cmath>
#include <sstream>
#include <stdexcept>

#include "engine/tracks/tracks.h"

namespace freelsd {
namespace {

struct Bound {
  const char* field;
  double value;
  double min;
  double max;
};

void RequireInside(const Bound& bound) {
  if (std::isfinite(bound.value) && bound.value >= bound.min && bound.value <= bound.max) return;
  std::ostringstream message;
  message << "tracks." << bound.field << " = " << bound.value << ": must be in [" << bound.min
          << ", " << bound.max << "]";
  throw std::invalid_argument(message.str());
}

}  // namespace

void TracksOptions::Check() const {
  const Bound bounds[] = {
      {"max_klt_flow_ratio", max_klt_flow_ratio, 0.0, 1.0},
      {"max_num_corners", static_cast<double>(max_num_corners), 30, 10000},
      {"max_num_keypoints", static_cast<double>(max_num_keypoints), 50, 20000},
      {"matching_width_px", static_cast<double>(matching_width_px), 160, 8000},
      {"max_forward_backward_error_px", max_forward_backward_error_px, 0.01, 20.0},
      {"min_num_verified_matches", static_cast<double>(min_num_verified_matches), 8, 1000},
      {"max_verification_error_px", max_verification_error_px, 0.1, 50.0},
      {"max_num_match_partners", static_cast<double>(max_num_match_partners), 0, 100},
      {"num_nearest_tracks", static_cast<double>(num_nearest_tracks), 3, 1000},
      {"min_parallax_deg", min_parallax_deg, 0.1, 60.0},
      {"max_reprojection_error_px", max_reprojection_error_px, 0.1, 200.0},
      {"max_attitude_disagreement_deg", max_attitude_disagreement_deg, 5.0, 180.0},
      {"nadir_sd_deg", nadir_sd_deg, 0.5, 30.0},
      {"ground_matching_width_px", static_cast<double>(ground_matching_width_px), 160, 8000},
      {"max_num_ground_keypoints", static_cast<double>(max_num_ground_keypoints), 50, 20000},
      {"min_num_tie_matches", static_cast<double>(min_num_tie_matches), 8, 1000},
      {"min_ground_overlap_ratio", min_ground_overlap_ratio, 0.0, 1.0},
      {"max_ground_error_ratio", max_ground_error_ratio, 0.001, 1.0},
      {"max_num_waiting_frames", static_cast<double>(max_num_waiting_frames), 2, 200},
  };
  for (const Bound& bound : bounds) RequireInside(bound);
}

}  // namespace freelsd
