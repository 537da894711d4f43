#include "engine/tracks/tracks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/engine/tracks/synthetic_flight.h"

namespace freelsd {
namespace {

constexpr double kHeightM = 100.0;

Rig SurveyRig() {
  Rig rig;
  rig.camera = CenteredCamera(400, 300, 280.0);
  return rig;
}

// Fewer keypoints than usual: the plane has texture everywhere.
TracksOptions FastOptions() {
  TracksOptions options;
  options.max_num_keypoints = 500;
  options.max_num_match_partners = 4;
  return options;
}

double Median(std::vector<double> values) {
  REQUIRE(!values.empty());
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double HeadingErrorDeg(const Rigid3d& estimated, const Rigid3d& truth) {
  const Eigen::Vector3d up = estimated.rotation * Eigen::Vector3d(0, -1, 0);
  const Eigen::Vector3d true_up = truth.rotation * Eigen::Vector3d(0, -1, 0);
  return std::abs(DegFromRad(WrapAngle(HeadingOf(up.head<2>()) - HeadingOf(true_up.head<2>()))));
}

std::vector<ReadyFrame> AddAll(Tracks& tracks, std::vector<Frame> frames) {
  std::vector<ReadyFrame> all;
  for (Frame& frame : frames) {
    for (ReadyFrame& ready : tracks.Add(std::move(frame))) all.push_back(std::move(ready));
  }
  for (ReadyFrame& ready : tracks.Flush()) all.push_back(std::move(ready));
  return all;
}

std::vector<Frame> Video(SyntheticFlight& flight, int count, const Noise& noise) {
  std::vector<Frame> frames;
  frames.reserve(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) {
    frames.push_back(flight.Expose({3.4 * i - 40.0, 0.0, kHeightM},
                                   {.roll = 0.02 * std::sin(i), .pitch = 0.03, .yaw = 1.4},
                                   noise));
  }
  return frames;
}

// Three lines there and back, strong crab, tilts of 6 deg.
std::vector<Frame> Survey(SyntheticFlight& flight, const Noise& noise) {
  std::vector<Frame> frames;
  for (int line = 0; line < 3; ++line) {
    for (int i = 0; i < 5; ++i) {
      const bool is_back = line % 2 == 1;
      const double along = 40.0 * (is_back ? 4 - i : i) - 80.0;
      const Eigen::Vector3d tilt = RadFromDeg(6.0) * flight.Random3();
      const double track = is_back ? -kPi / 2 : kPi / 2;
      const double crab = RadFromDeg(is_back ? -40.0 : 40.0);
      frames.push_back(
          flight.Expose({along, 45.0 * line - 45.0, kHeightM + 2.0 * flight.Random3().x()},
                        {.roll = tilt.x(), .pitch = tilt.y(), .yaw = track + crab},
                        noise));
    }
  }
  return frames;
}

void CheckOneObservationPerView(const Tracks& tracks) {
  for (const View& view : tracks.views()) {
    std::set<int64_t> seen;
    for (const Observation& observation : view.observations) {
      CHECK(seen.insert(observation.track_id).second);
    }
  }
}

TEST_CASE("tracks: a video is followed, and its height found within 3 percent") {
  constexpr double kMaxHeightErrorM = 3.0;
  constexpr size_t kMinTracksPerView = 120;
  const Rig rig = VideoRig();
  SyntheticFlight flight(rig, 160.0);
  Tracks tracks(rig, FastOptions());
  const auto ready = AddAll(tracks, Video(flight, 24, Noise{}));
  REQUIRE(ready.size() == 24);
  REQUIRE(tracks.views().size() == 24);
  std::map<int64_t, int> lengths;
  for (const View& view : tracks.views()) {
    CHECK(view.observations.size() > kMinTracksPerView);
    CHECK(std::abs(view.height_above_ground - kHeightM) < kMaxHeightErrorM);
    for (const Observation& observation : view.observations) ++lengths[observation.track_id];
  }
  const auto longest = std::max_element(
      lengths.begin(), lengths.end(), [](auto a, auto b) { return a.second < b.second; });
  CHECK(longest->second >= 12);
  CheckOneObservationPerView(tracks);
}

TEST_CASE("tracks: a pixel is brought to the ground within 2 m, above the horizon to nowhere") {
  constexpr double kMaxErrorM = 2.0;
  const Rig rig = VideoRig();
  SyntheticFlight flight(rig, 160.0);
  Tracks tracks(rig, FastOptions());
  AddAll(tracks, Video(flight, 16, Noise{}));
  const size_t last = tracks.views().size() - 1;
  const Rigid3d& truth = flight.TruthOf(tracks.views()[last].frame_id);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(100, 80), Eigen::Vector2d(600, 400)}) {
    const auto ground = tracks.GroundAt(last, pixel);
    REQUIRE(ground);
    const Eigen::Vector3d ray = truth.rotation * rig.camera.RayFromImage(pixel);
    const Eigen::Vector3d expected = truth.translation - ray * (truth.translation.z() / ray.z());
    CHECK((ground->point_in_world - expected).norm() < kMaxErrorM);
    CHECK(ground->height_sd_m < kMaxErrorM);
  }
  Rigid3d level = truth;
  level.rotation = Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitX()) * truth.rotation;
  tracks.SetPose(last, level, {});
  CHECK(!tracks.GroundAt(last, {375.0, 240.0}));
}

TEST_CASE("tracks: noisy priors of 1 m and 1 degree leave the height within 8 percent") {
  constexpr double kMaxMedianErrorM = 8.0;
  const Rig rig = VideoRig();
  SyntheticFlight flight(rig, 160.0);
  Tracks tracks(rig, FastOptions());
  AddAll(tracks, Video(flight, 24, {.position_sd_m = 1.0, .attitude_sd_deg = 1.0}));
  REQUIRE(tracks.views().size() == 24);
  std::vector<double> errors;
  for (const View& view : tracks.views()) {
    errors.push_back(std::abs(view.height_above_ground - kHeightM));
  }
  CHECK(Median(errors) < kMaxMedianErrorM);
}

TEST_CASE("tracks: survey photographs without attitude find heading and height") {
  constexpr double kMaxHeadingErrorDeg = 5.0;
  constexpr double kMaxHeightErrorRatio = 0.05;
  const Rig rig = SurveyRig();
  SyntheticFlight flight(rig, 240.0);
  std::vector<Frame> frames = Survey(flight, {.position_sd_m = 1.5});
  for (Frame& frame : frames) frame.prior.world_from_body.reset();
  Tracks tracks(rig, FastOptions());
  const auto ready = AddAll(tracks, std::move(frames));
  CHECK(ready.size() == 15);
  REQUIRE(tracks.views().size() == 15);
  std::vector<double> heading_errors, height_errors;
  for (const View& view : tracks.views()) {
    const Rigid3d& truth = flight.TruthOf(view.frame_id);
    CHECK(view.attitude_source == AttitudeSource::kEstimated);
    heading_errors.push_back(HeadingErrorDeg(view.world_from_camera, truth));
    height_errors.push_back(std::abs(view.height_above_ground / truth.translation.z() - 1.0));
  }
  CHECK(Median(heading_errors) < kMaxHeadingErrorDeg);
  CHECK(Median(height_errors) < kMaxHeightErrorRatio);
  CHECK(*std::max_element(heading_errors.begin(), heading_errors.end()) < 20.0);
  CheckOneObservationPerView(tracks);
}

TEST_CASE("tracks: tracks join across flight lines") {
  const Rig rig = SurveyRig();
  SyntheticFlight flight(rig, 240.0);
  Tracks tracks(rig, FastOptions());
  AddAll(tracks, Survey(flight, Noise{}));
  REQUIRE(tracks.views().size() == 15);
  std::map<int64_t, std::set<int>> lines_of_track;
  for (size_t view = 0; view < 15; ++view) {
    for (const Observation& observation : tracks.views()[view].observations) {
      lines_of_track[observation.track_id].insert(static_cast<int>(view) / 5);
    }
  }
  const auto num_joined = std::count_if(lines_of_track.begin(),
                                        lines_of_track.end(),
                                        [](const auto& entry) { return entry.second.size() > 1; });
  CHECK(num_joined > 100);
}

TEST_CASE("tracks: photographs turned by 180 degrees after exposure are found and said so") {
  constexpr double kMaxErrorDeg = 3.0;
  const Rig rig = SurveyRig();
  SyntheticFlight flight(rig, 240.0);
  std::vector<Frame> frames = Survey(flight, {.position_sd_m = 1.0, .attitude_sd_deg = 1.0});
  // In the middle of the flight, or from its start on.
  const size_t first_turned = 6, last_turned = 9;
  for (const bool is_from_start : {false, true}) {
    std::vector<Frame> given = frames;
    const auto is_turned = [&](size_t i) {
      return is_from_start ? i < 3 : i >= first_turned && i <= last_turned;
    };
    for (size_t i = 0; i < given.size(); ++i) {
      cv::Mat turned;
      cv::rotate(given[i].image, turned, cv::ROTATE_180);
      if (is_turned(i)) given[i].image = turned;
    }
    Tracks tracks(rig, FastOptions());
    const auto ready = AddAll(tracks, std::move(given));
    REQUIRE(ready.size() == frames.size());
    for (size_t i = 0; i < ready.size(); ++i) {
      REQUIRE(ready[i].view);
      const View& view = tracks.views()[*ready[i].view];
      const double error = HeadingErrorDeg(view.world_from_camera, flight.TruthOf(view.frame_id));
      const double expected = is_turned(i) ? 180.0 : 0.0;
      CHECK(std::abs(error - expected) < kMaxErrorDeg);
      CHECK((view.attitude_source == AttitudeSource::kCorrected) == is_turned(i));
      CHECK(ready[i].note.empty() != is_turned(i));
    }
  }
}

TEST_CASE("tracks: black images are given up when no height is known, and crash nothing") {
  const Rig rig = VideoRig();
  SyntheticFlight flight(rig, 120.0);
  std::vector<Frame> frames = Video(flight, 5, Noise{});
  for (Frame& frame : frames) frame.image = cv::Mat::zeros(frame.image.size(), CV_8U);
  SUBCASE("attitude given") {}
  SUBCASE("no attitude") {
    for (Frame& frame : frames) frame.prior.world_from_body.reset();
  }
  Tracks tracks(rig, FastOptions());
  const auto ready = AddAll(tracks, std::move(frames));
  REQUIRE(ready.size() == 5);
  CHECK(tracks.views().empty());
  for (const ReadyFrame& frame : ready) {
    CHECK(!frame.view);
    CHECK(!frame.note.empty());
  }
}

TEST_CASE("tracks: a hover tells no height, however long it lasts") {
  const Rig rig = VideoRig();
  SyntheticFlight flight(rig, 120.0);
  std::vector<Frame> frames;
  Noise noise;
  SUBCASE("the same pose") {}
  SUBCASE("the same place, noisy priors") {
    noise = {.position_sd_m = 1.5, .attitude_sd_deg = 2.0};
  }
  frames.reserve(16);
  for (int i = 0; i < 16; ++i) {
    frames.push_back(flight.Expose({0.0, 0.0, kHeightM}, {.roll = 0.01}, noise));
  }
  const bool has_attitude = noise.position_sd_m == 0.0;
  for (Frame& frame : frames) {
    frame.prior.position_sd_m = 2.0;
    if (!has_attitude) frame.prior.attitude_sd_deg = 2.0;
  }
  Tracks tracks(rig, FastOptions());
  const auto ready = AddAll(tracks, std::move(frames));
  CHECK(ready.size() == 16);
  CHECK(tracks.views().empty());
}

TEST_CASE("tracks: a given height needs no neighbours, a plane can be assumed") {
  const Rig rig = VideoRig();
  SyntheticFlight flight(rig, 120.0);
  Frame frame = flight.Expose({0.0, 0.0, kHeightM}, EulerAngles{}, Noise{});
  TracksOptions options;
  SUBCASE("given") { frame.height_above_ground = 97.0; }
  SUBCASE("below take-off") { options.assume_ground_plane = true; }
  const double expected = frame.height_above_ground.value_or(kHeightM);
  Tracks tracks(rig, options);
  AddAll(tracks, {frame});
  REQUIRE(tracks.views().size() == 1);
  CHECK(tracks.views()[0].height_above_ground == doctest::Approx(expected));
  const auto ground = tracks.GroundAt(0, {375.5, 239.5});
  REQUIRE(ground);
  CHECK(ground->point_in_world.z() == doctest::Approx(kHeightM - expected));
  CHECK(ground->height_sd_m > 0.0);
}

TEST_CASE("tracks: at most so many frames wait, and none is lost") {
  const Rig rig = SurveyRig();
  SyntheticFlight flight(rig, 120.0);
  TracksOptions options = FastOptions();
  options.max_num_waiting_frames = 3;
  Tracks tracks(rig, options);
  std::set<std::string> handed_out;
  int num_added = 0;
  for (int i = 0; i < 6; ++i) {
    Frame frame = flight.Expose({1000.0 * i, 0.0, kHeightM}, EulerAngles{}, Noise{});
    frame.image = cv::Scalar(128);
    frame.prior.world_from_body.reset();
    ++num_added;
    for (const ReadyFrame& ready : tracks.Add(frame)) handed_out.insert(ready.frame.id);
    CHECK(num_added - static_cast<int>(handed_out.size()) <= options.max_num_waiting_frames);
  }
  for (const ReadyFrame& ready : tracks.Flush()) handed_out.insert(ready.frame.id);
  CHECK(handed_out.size() == 6);
}

TEST_CASE("tracks: a better pose moves the ground point with it") {
  const Rig rig = VideoRig();
  SyntheticFlight flight(rig, 120.0);
  Tracks tracks(rig, FastOptions());
  Frame frame = flight.Expose({0.0, 0.0, kHeightM}, EulerAngles{}, Noise{});
  frame.height_above_ground = kHeightM;
  AddAll(tracks, {frame});
  const Eigen::Vector3d shift(5.0, -3.0, 2.0);
  const auto before = tracks.GroundAt(0, {200.0, 200.0});
  Rigid3d moved = tracks.views()[0].world_from_camera;
  moved.translation += shift;
  tracks.SetPose(0, moved, {});
  const auto after = tracks.GroundAt(0, {200.0, 200.0});
  REQUIRE(before);
  REQUIRE(after);
  CHECK(after->point_in_world.z() == doctest::Approx(0.0));
  CHECK(tracks.views()[0].height_above_ground == doctest::Approx(kHeightM + 2.0));
}

TEST_CASE("tracks: an image of another size is refused with both sizes") {
  Tracks tracks(VideoRig(), TracksOptions{});
  Frame frame;
  frame.id = "12";
  frame.image = cv::Mat::zeros(480, 640, CV_8U);
  CHECK_THROWS_WITH_AS(
      tracks.Add(frame), "frame 12: image is 640x480, camera says 752x480", std::invalid_argument);
}

TEST_CASE("tracks: the same flight gives the same views twice") {
  const Rig rig = SurveyRig();
  SyntheticFlight flight(rig, 240.0);
  std::vector<Frame> frames = Survey(flight, {.position_sd_m = 1.5});
  frames.resize(6);
  for (Frame& frame : frames) frame.prior.world_from_body.reset();
  Tracks first(rig, FastOptions()), second(rig, FastOptions());
  AddAll(first, frames);
  AddAll(second, frames);
  REQUIRE(first.views().size() == second.views().size());
  for (size_t i = 0; i < first.views().size(); ++i) {
    CHECK(first.views()[i].world_from_camera.rotation.coeffs() ==
          second.views()[i].world_from_camera.rotation.coeffs());
    CHECK(first.views()[i].observations.size() == second.views()[i].observations.size());
  }
}

}  // namespace
}  // namespace freelsd
