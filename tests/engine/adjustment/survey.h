// A survey flight over rolling ground, as the tracker would describe it, with its truth.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "engine/adjustment/adjustment.h"
#include "tests/engine/camera.h"

namespace freelsd {

inline constexpr double kNoisePx = 0.5;
// Noise of both axes, and what a robust solver may leave on top.
inline constexpr double kMaxRmsPx = 0.8;

inline int NumConnected(const AdjustedBlock& block) {
  return static_cast<int>(std::count_if(
      block.views.begin(), block.views.end(), [](const auto& view) { return view.is_connected; }));
}

struct SurveyOptions {
  int num_strips = 4;
  int num_per_strip = 6;
  double spacing_m = 30.0;
  double strip_spacing_m = 45.0;
  double height_m = 100.0;
  double relief_m = 4.0;
  int num_points = 1500;
  double pixel_sd_px = 0.5;
  double outlier_ratio = 0.03;
  // Of the priors; start errors are uniform within the bounds.
  double gps_sd_m = 2.0;
  double start_yaw_error_deg = 0.0;
  double start_tilt_error_deg = 2.0;
  double height_factor = 1.0;
  // The camera turns by up to this about each axis while an image is read, radians.
  double readout_turn = 0.0;
  // And by up to this unevenly: the second power of time, see Readout::turns.
  double readout_bend = 0.0;
  // And by up to this at the first and last row, by each of the third to the fifth power.
  double readout_gust = 0.0;
  AttitudeSource attitude_source = AttitudeSource::kGiven;
  unsigned seed = 7;
};

struct Survey {
  Camera camera;
  std::vector<View> views;
  std::vector<Rigid3d> world_from_camera;
  std::vector<Eigen::Vector3d> points_in_world;
};

inline Camera SurveyCamera() { return CenteredCamera(1000, 750, 800.0); }

inline double SurveyGround(double east, double north, double relief_m) {
  return relief_m * (std::sin(east / 35.0) + std::cos(north / 28.0));
}

// Attitude of a camera looking down whose image top points along the heading.
inline Eigen::Quaterniond NadirCamera(double heading) {
  const Eigen::Quaterniond body_from_camera(0.7071067811865476, 0, 0, 0.7071067811865476);
  return WorldFromNed() * NedFromBody({0.0, 0.0, heading}) * body_from_camera;
}

class SurveyMaker {
 public:
  explicit SurveyMaker(const SurveyOptions& options) : options_(options), random_(options.seed) {}

  Survey Make() {
    Survey survey;
    survey.camera = SurveyCamera();
    for (int strip = 0; strip < options_.num_strips; ++strip) {
      for (int i = 0; i < options_.num_per_strip; ++i) AddView(strip, i, survey);
    }
    const double east_m = options_.spacing_m * options_.num_per_strip + 40.0;
    const double north_m = options_.strip_spacing_m * options_.num_strips + 40.0;
    for (int i = 0; i < options_.num_points; ++i) {
      const double east = Uniform(0.5 * east_m) + 0.5 * east_m - 35.0;
      const double north = Uniform(0.5 * north_m) + 0.5 * north_m - 40.0;
      survey.points_in_world.emplace_back(
          east, north, SurveyGround(east, north, options_.relief_m));
    }
    return survey;
  }

  // Pixels of the points in every view, by `base` (the true camera), each image displaced in its
  // own way while it is read.
  void Observe(const Camera& base, Survey& survey) {
    for (size_t view = 0; view < survey.views.size(); ++view) {
      const double bound = options_.readout_turn;
      const Eigen::Vector3d turn{Uniform(bound), Uniform(bound), Uniform(bound)};
      const Eigen::Vector3d bend = options_.readout_bend * turn / std::max(bound, 1e-9);
      Camera camera = base.With(Readout::Turning(turn, bend));
      for (int k = 2; options_.readout_gust > 0.0 && k < Readout::kNumTurns; ++k) {
        const double gust = options_.readout_gust * std::pow(2.0, k + 1);
        camera.readout.turns.col(k) << Uniform(gust), Uniform(gust), Uniform(gust);
      }
      for (size_t id = 0; id < survey.points_in_world.size(); ++id) {
        auto pixel = camera.ImageFromCamera(Inverse(survey.world_from_camera[view]) *
                                            survey.points_in_world[id]);
        if (!pixel || !camera.IsInside(*pixel)) continue;
        *pixel += options_.pixel_sd_px * Eigen::Vector2d{Normal(), Normal()};
        if (0.5 * (Uniform(1.0) + 1.0) < options_.outlier_ratio) {
          *pixel += Eigen::Vector2d{Uniform(80.0), Uniform(80.0)};
        }
        survey.views[view].observations.push_back({static_cast<int64_t>(id), *pixel});
      }
    }
  }

 private:
  double Uniform(double bound) {
    return std::uniform_real_distribution<double>(-bound, bound)(random_);
  }
  double Normal() { return std::normal_distribution<double>()(random_); }
  Eigen::Quaterniond Tilt(double bound_deg) {
    const Eigen::Vector3d axis{Uniform(1.0), Uniform(1.0), 0.0};
    return Eigen::Quaterniond(Eigen::AngleAxisd(RadFromDeg(Uniform(bound_deg)), axis.normalized()));
  }

  void AddView(int strip, int i, Survey& survey) {
    const int along = strip % 2 == 0 ? i : options_.num_per_strip - 1 - i;
    const double heading = strip % 2 == 0 ? kPi / 2 : -kPi / 2;
    Rigid3d truth;
    truth.translation = {along * options_.spacing_m + Uniform(2.0),
                         strip * options_.strip_spacing_m + Uniform(2.0),
                         options_.height_m + Uniform(3.0)};
    const Eigen::Quaterniond tilt = Tilt(4.0);
    truth.rotation = tilt * NadirCamera(heading + RadFromDeg(Uniform(5.0)));
    View view;
    view.frame_id = std::to_string(survey.views.size());
    view.timestamp_us = static_cast<int64_t>(survey.views.size()) * 2'000'000;
    view.position_sd_m = options_.gps_sd_m;
    view.prior_position_in_world =
        truth.translation + options_.gps_sd_m * Eigen::Vector3d{Normal(), Normal(), Normal()};
    view.attitude_source = options_.attitude_source;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(
        RadFromDeg(Uniform(options_.start_yaw_error_deg)), Eigen::Vector3d::UnitZ()));
    view.world_from_camera = {turn * Tilt(options_.start_tilt_error_deg) * truth.rotation,
                              view.prior_position_in_world};
    view.prior_world_from_camera = view.world_from_camera.rotation;
    view.height_above_ground = options_.height_m * options_.height_factor;
    survey.world_from_camera.push_back(truth);
    survey.views.push_back(view);
  }

  SurveyOptions options_;
  std::mt19937 random_;
};

inline Survey MakeSurvey(const SurveyOptions& options) {
  SurveyMaker maker(options);
  Survey survey = maker.Make();
  maker.Observe(survey.camera, survey);
  return survey;
}

// What is left of the pose errors after one common shift: of the block's shape, not of its place.
struct ShapeError {
  double shift_m = 0.0;
  double max_position_m = 0.0;
  double max_attitude_deg = 0.0;
};

inline ShapeError CompareWithTruth(const Survey& survey, const AdjustedBlock& block) {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < block.views.size(); ++i) {
    shift += block.views[i].world_from_camera.translation - survey.world_from_camera[i].translation;
  }
  shift /= static_cast<double>(block.views.size());
  ShapeError error{shift.norm(), 0.0, 0.0};
  for (size_t i = 0; i < block.views.size(); ++i) {
    const Rigid3d& pose = block.views[i].world_from_camera;
    const Rigid3d& truth = survey.world_from_camera[i];
    error.max_position_m =
        std::max(error.max_position_m, (pose.translation - shift - truth.translation).norm());
    error.max_attitude_deg =
        std::max(error.max_attitude_deg, DegFromRad(AngleBetween(pose.rotation, truth.rotation)));
  }
  return error;
}

}  // namespace freelsd
