#include "tests/evaluation/look/look_world.h"

#include <cmath>

#include <opencv2/imgcodecs.hpp>

#include "tests/synthetic/conditions/conditions.h"
#include "tests/synthetic/noise.h"
#include "tests/synthetic/renderer.h"

namespace freelsd {
namespace {

constexpr uint64_t kRandomLegPurpose = 601;
// The fewest photographs that a scenario has; they are replaced.
constexpr int kFewFrames = 3;

Scenario WorldOnly(uint64_t seed, const LookWorldOptions& options) {
  ScenarioOptions scenario;
  scenario.num_frames = kFewFrames;
  scenario.takes_photographs = false;
  scenario.aircraft = options.aircraft;
  Scenario made = MakeScenario(seed, scenario, [](double) {});
  made.exposures.clear();
  return made;
}

Frame FrameOf(const SyntheticExposure& exposure, const cv::Mat& image) {
  Frame frame;
  frame.id = exposure.image;
  frame.timestamp_us = exposure.timestamp_us;
  frame.image = image;
  frame.prior.position_in_world = exposure.reported.position_in_world;
  frame.prior.world_from_body = WorldFromBody(exposure.reported).rotation;
  frame.wind_in_world = exposure.reported_wind_in_world;
  return frame;
}

}  // namespace

LookWorld::LookWorld(uint64_t seed, const LookWorldOptions& options)
    : seed_(seed), options_(options), scenario_(WorldOnly(seed, options)) {
  for (int i = 0; i < options.num_survey_legs; ++i) {
    const SyntheticLeg leg = SurveyLeg(i, options.survey_leg_m);
    area_.Add(leg.from);
    area_.Add(leg.to);
    if (i >= options.num_survey_legs / 2) continue;
    for (Frame& frame : Photograph(leg)) survey_.push_back(std::move(frame));
  }
  area_.Grow(options.margin_m);
}

SyntheticLeg LookWorld::SurveyLeg(int number, double length_m) const {
  const double east = (number - 0.5 * (options_.num_survey_legs - 1)) * options_.leg_spacing_m;
  const double north = number % 2 == 0 ? 0.5 * length_m : -0.5 * length_m;
  return {{east, -north}, {east, north}, number};
}

std::vector<Frame> LookWorld::Photograph(const SyntheticLeg& leg) const {
  FlightOptions flight;
  flight.seed = seed_;
  flight.height_above_origin_m = options_.height_m;
  flight.frame_period_s = options_.frame_spacing_m / flight.airspeed_mps;
  const Conditions conditions = PlainConditions(seed_);
  std::vector<Frame> frames;
  for (const SyntheticExposure& exposure : PlanLeg(flight, leg, scenario_.world.wind_in_world)) {
    const World moment =
        scenario_.world.At(1e-6 * static_cast<double>(exposure.timestamp_us - flight.start_us));
    const Rigid3d world_from_camera =
        WorldFromBody(exposure.truth) * scenario_.rig.body_from_camera;
    const cv::Mat image = Renderer(moment).Render(scenario_.rig.camera,
                                                  world_from_camera,
                                                  conditions.camera,
                                                  1000 * leg.id + static_cast<int>(frames.size()));
    std::vector<uchar> bytes;
    cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, conditions.jpeg_quality});
    frames.push_back(FrameOf(exposure, cv::imdecode(bytes, cv::IMREAD_COLOR)));
  }
  return frames;
}

SyntheticLeg LookWorld::RandomLeg(int number) const {
  const uint64_t seed = MixSeed(seed_, kRandomLegPurpose + static_cast<uint64_t>(number));
  for (uint64_t attempt = 0;; ++attempt) {
    const Eigen::Vector2d middle(Uniform(seed, 3 * attempt, area_.min.x(), area_.max.x()),
                                 Uniform(seed, 3 * attempt + 1, area_.min.y(), area_.max.y()));
    const Eigen::Vector2d half =
        0.5 * options_.look_leg_m * DirectionOf(Uniform(seed, 3 * attempt + 2, 0.0, 2.0 * kPi));
    SyntheticLeg leg{middle - half, middle + half, options_.num_survey_legs + number};
    if (area_.DistanceTo(leg.from) == 0.0 && area_.DistanceTo(leg.to) == 0.0) return leg;
  }
}

}  // namespace freelsd
