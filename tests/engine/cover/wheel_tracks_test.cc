#include "engine/cover/wheel_tracks.h"

#include <doctest/doctest.h>

#include "tests/engine/cover/photo.h"

namespace freelsd {
namespace {

using photo::AlongAndAcross;
using photo::Color;
using photo::MapGridOf;
using photo::OffMultiple;
using photo::Paint;
using photo::Painted;

constexpr double kSideM = 128.0;
constexpr double kRutHalfWidthM = 0.225;
constexpr double kGaugeM = 1.9;
constexpr double kWorkingWidthM = 24.0;
// Tracks are painted as far as this from the middle.
constexpr double kHalfLengthM = 40.0;
// Of a track's place: half a square of places, and half a cell of the map.
constexpr double kPlaceErrorM = 1.0;

bool IsRut(double across) { return std::abs(std::abs(across) - 0.5 * kGaugeM) <= kRutHalfWidthM; }

// Pairs of ruts a spacing apart: the one through the middle and `num_beside` to either side.
Paint Tracks(double turn_deg,
             double spacing_m,
             int num_beside,
             const Color& ground = photo::kGreen,
             const Color& rut = photo::kRut) {
  return [=](const Eigen::Vector2d& place) {
    const Eigen::Vector2d at = AlongAndAcross(place, turn_deg);
    const bool is_beyond = std::abs(at.y()) > (num_beside + 0.5) * spacing_m;
    if (is_beyond || std::abs(at.x()) > kHalfLengthM) return ground;
    return IsRut(OffMultiple(at.y(), spacing_m)) ? rut : ground;
  };
}

// Single lines, each as wide as given.
Paint Lines(double turn_deg, double spacing_m, double width_m, const Color& line) {
  return [=](const Eigen::Vector2d& place) {
    const Eigen::Vector2d at = AlongAndAcross(place, turn_deg);
    return OffMultiple(at.y(), spacing_m) <= 0.5 * width_m ? line : photo::kGreen;
  };
}

cv::Mat1b SprayedOn(const Orthophoto& photo, const CoverOptions& options = {}) {
  return SprayedGround(FindWheelTracks(photo, options), MapGridOf(photo), options);
}

int NumSprayed(const Orthophoto& photo) { return cv::countNonZero(SprayedOn(photo)); }

TEST_CASE("wheel tracks: a sprayed field is found up to half a working width beyond its tracks") {
  for (const double turn_deg : {0.0, 37.0, 90.0, 133.0}) {
    CAPTURE(turn_deg);
    const Orthophoto photo = Painted(kSideM, Tracks(turn_deg, kWorkingWidthM, 1));
    const Grid grid = MapGridOf(photo);
    const cv::Mat1b sprayed = SprayedOn(photo);
    const double margin_m = CoverOptions{}.sprayed_margin_m;
    const double reach_m = kWorkingWidthM + 0.5 * kWorkingWidthM;
    int num_missed = 0, num_too_far = 0;
    for (int row = 0; row < sprayed.rows; ++row) {
      for (int col = 0; col < sprayed.cols; ++col) {
        const Eigen::Vector2d at = AlongAndAcross(grid.CellCenter(row, col), turn_deg).cwiseAbs();
        const bool is_field = at.x() <= kHalfLengthM && at.y() <= reach_m;
        const bool is_far = at.y() > reach_m + margin_m + 2.0 * kPlaceErrorM ||
                            at.x() > kHalfLengthM + 0.5 * kWorkingWidthM + margin_m + 4.0;
        if (is_field && !sprayed(row, col)) ++num_missed;
        if (is_far && sprayed(row, col)) ++num_too_far;
      }
    }
    CHECK(num_missed == 0);
    CHECK(num_too_far == 0);
  }
}

TEST_CASE("wheel tracks: tracks lie midway between their ruts, with their length and direction") {
  for (const double turn_deg : {0.0, 37.0, 90.0, 133.0}) {
    CAPTURE(turn_deg);
    const std::vector<WheelTrack> tracks =
        FindWheelTracks(Painted(kSideM, Tracks(turn_deg, kWorkingWidthM, 1)), {});
    CHECK(tracks.size() == 3);
    for (const WheelTrack& track : tracks) {
      const Eigen::Vector2d start = AlongAndAcross(track.start, turn_deg);
      const Eigen::Vector2d end = AlongAndAcross(track.end, turn_deg);
      CHECK(OffMultiple(start.y(), kWorkingWidthM) < kPlaceErrorM);
      CHECK(OffMultiple(end.y(), kWorkingWidthM) < kPlaceErrorM);
      const double length_error_m = (track.end - track.start).norm() - 2.0 * kHalfLengthM;
      CHECK(std::abs(length_error_m) < CoverOptions{}.rut_filter_length_m);
    }
  }
}

TEST_CASE("wheel tracks: a single pair of ruts is a track, and sprays nothing") {
  const Orthophoto photo = Painted(kSideM, Tracks(37.0, kWorkingWidthM, 0));
  CHECK(FindWheelTracks(photo, {}).size() == 1);
  CHECK(NumSprayed(photo) == 0);
}

TEST_CASE("wheel tracks: tracks that cross, or lie farther apart than a sprayer, spray nothing") {
  const Paint one_way = Tracks(20.0, kWorkingWidthM, 0), other_way = Tracks(100.0, 24.0, 0);
  CHECK(NumSprayed(Painted(kSideM, [&](const Eigen::Vector2d& place) {
          const Color color = one_way(place);
          return color == photo::kRut ? color : other_way(place);
        })) == 0);
  CHECK(NumSprayed(Painted(kSideM, Tracks(0.0, 50.0, 1))) == 0);
}

TEST_CASE("wheel tracks: ditches, fences and paths are single lines, and no tracks") {
  const Color shadow{40.0, 66.0, 44.0}, gravel{150.0, 158.0, 160.0};
  for (const double turn_deg : {0.0, 28.0, 90.0}) {
    CHECK(NumSprayed(Painted(kSideM, Lines(turn_deg, 24.0, 0.5, photo::kRut))) == 0);
    CHECK(NumSprayed(Painted(kSideM, Lines(turn_deg, 24.0, 0.3, shadow))) == 0);
    CHECK(NumSprayed(Painted(kSideM, Lines(turn_deg, 24.0, 2.0, gravel))) == 0);
  }
}

TEST_CASE("wheel tracks: mowing three metres apart is a meadow's") {
  CHECK(NumSprayed(Painted(kSideM, Tracks(12.0, 3.0, 10))) == 0);
  const Color mown{66.0, 116.0, 84.0};
  const Paint swaths = [&](const Eigen::Vector2d& place) {
    const double across = AlongAndAcross(place, 64.0).y();
    return std::fmod(std::abs(across), 6.0) < 3.0 ? mown : photo::kGreen;
  };
  CHECK(NumSprayed(Painted(kSideM, swaths)) == 0);
}

TEST_CASE("wheel tracks: noise alone, unseen ground and an empty picture spray nothing") {
  const Paint even = [](const Eigen::Vector2d&) { return photo::kGreen; };
  // Chance may make a track, but not one beside another.
  CHECK(NumSprayed(Painted(kSideM, even, 3.0 * photo::kNoise)) == 0);
  CHECK(FindWheelTracks(Painted(kSideM, even), {}).empty());
  Orthophoto unseen = Painted(kSideM, Tracks(0.0, kWorkingWidthM, 1));
  photo::MakeUnseen(unseen, cv::Rect({0, 0}, unseen.image.size()));
  CHECK(FindWheelTracks(unseen, {}).empty());
  CHECK(FindWheelTracks(Orthophoto{}, {}).empty());
}

TEST_CASE("wheel tracks: unseen stripes and holes on a meadow are no ruts") {
  Orthophoto photo = Painted(kSideM, [](const Eigen::Vector2d&) { return photo::kGreen; });
  for (int col = 40; col < photo.image.cols; col += 96) {
    photo::MakeUnseen(photo, {col, 0, 2, photo.image.rows});
    photo::MakeUnseen(photo, {col + 8, 0, 2, photo.image.rows});
  }
  CHECK(NumSprayed(photo) == 0);
}

TEST_CASE("wheel tracks: tracks are found beside what was not seen") {
  Orthophoto photo = Painted(kSideM, Tracks(90.0, kWorkingWidthM, 1));
  photo::MakeUnseen(photo, {0, 0, photo.image.cols, photo.image.rows / 2});
  CHECK(FindWheelTracks(photo, {}).size() == 3);
  CHECK(NumSprayed(photo) > 40 * 72);
}

TEST_CASE("wheel tracks: ruts in soil and stubble are not looked for") {
  const Color soil{90.0, 110.0, 122.0}, damp{60.0, 74.0, 86.0};
  const Color stubble{140.0, 180.0, 205.0}, pressed{120.0, 145.0, 175.0};
  CHECK(NumSprayed(Painted(kSideM, Tracks(37.0, kWorkingWidthM, 1, soil, damp))) == 0);
  CHECK(NumSprayed(Painted(kSideM, Tracks(37.0, kWorkingWidthM, 1, stubble, pressed))) == 0);
}

TEST_CASE("wheel tracks: shade over ruts and plants alike changes nothing") {
  const Paint tracks = Tracks(37.0, kWorkingWidthM, 1);
  const Paint shaded = [&](const Eigen::Vector2d& place) {
    return tracks(place) * (place.x() > 0.0 ? 0.6 : 1.0);
  };
  const cv::Mat1b sunlit = SprayedOn(Painted(kSideM, tracks, 4.0));
  const cv::Mat1b half_shaded = SprayedOn(Painted(kSideM, shaded, 4.0));
  CHECK(cv::countNonZero(half_shaded) > 0.97 * cv::countNonZero(sunlit));
}

TEST_CASE("wheel tracks: options decide what contrast, length and working width count") {
  const Orthophoto photo = Painted(kSideM, Tracks(0.0, kWorkingWidthM, 1));
  CoverOptions options;
  options.min_rut_contrast = 0.4;
  CHECK(cv::countNonZero(SprayedOn(photo, options)) == 0);
  options = {};
  options.min_track_length_m = 100.0;
  CHECK(cv::countNonZero(SprayedOn(photo, options)) == 0);
  options = {};
  options.max_working_width_m = 20.0;
  CHECK(cv::countNonZero(SprayedOn(photo, options)) == 0);
}

}  // namespace
}  // namespace freelsd
