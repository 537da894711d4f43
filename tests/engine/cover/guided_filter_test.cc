#include "engine/cover/guided_filter.h"

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr double kRadiusM = 8.0;
constexpr double kLeastContrast = 0.017;
constexpr int kPhotoCellsPerCell = 4;
const cv::Vec3b kMeadow(40, 120, 80);

Orthophoto EvenPhoto(const cv::Size& cells) {
  Orthophoto photo;
  photo.image = cv::Mat3b(cells * kPhotoCellsPerCell, kMeadow);
  photo.seen = cv::Mat1b(cells * kPhotoCellsPerCell, uint8_t{255});
  return photo;
}

// The photograph's cells of the map's cells.
cv::Rect InPhoto(const cv::Rect& cells) {
  return {cells.tl() * kPhotoCellsPerCell, cells.size() * kPhotoCellsPerCell};
}

cv::Mat1f NoiseAroundOne(const cv::Size& size) {
  cv::Mat1f values(size);
  cv::RNG random(7);
  for (float& value : values) value = static_cast<float>(1.0 + random.gaussian(0.5));
  return values;
}

cv::Mat1f Smoothed(const cv::Mat1f& values, const Orthophoto& photo) {
  return SmoothedByPhoto(values, photo, 1.0, kRadiusM, kLeastContrast);
}

double SpreadOf(const cv::Mat1f& values) {
  cv::Scalar mean, spread;
  cv::meanStdDev(values, mean, spread);
  return spread[0];
}

TEST_CASE("guided filter: noise goes where the photograph is even") {
  const cv::Mat1f values = NoiseAroundOne({60, 60});
  const cv::Mat1f smoothed = Smoothed(values, EvenPhoto(values.size()));
  CHECK(SpreadOf(values) > 0.45);
  CHECK(SpreadOf(smoothed) < 0.06);
}

TEST_CASE("guided filter: a step of the photograph stays a step, also along a footpath") {
  const cv::Size size(60, 60);
  for (const cv::Rect& other : {cv::Rect(0, 0, 60, 30), cv::Rect(0, 29, 60, 2)}) {
    cv::Mat1f values = NoiseAroundOne(size);
    values(other) -= 1.0;
    Orthophoto photo = EvenPhoto(size);
    photo.image(InPhoto(other)).setTo(cv::Vec3b(90, 140, 150));
    const cv::Mat1f smoothed = Smoothed(values, photo);
    CHECK(cv::mean(smoothed(other))[0] == doctest::Approx(0.0).epsilon(0.12));
    const cv::Rect beside(0, other.br().y, 60, 2);
    CHECK(cv::mean(smoothed(beside))[0] > 0.85);
    // The photograph alone makes no step.
    CHECK(cv::mean(Smoothed(NoiseAroundOne(size), photo)(other))[0] > 0.85);
  }
}

TEST_CASE("guided filter: what is unknown, or without a photograph, stays as it is") {
  cv::Mat1f values = NoiseAroundOne({40, 40});
  const cv::Rect unknown(10, 10, 5, 5), unseen(20, 20, 6, 6);
  values(unknown).setTo(std::numeric_limits<float>::quiet_NaN());
  Orthophoto photo = EvenPhoto(values.size());
  photo.image(InPhoto(unseen)).setTo(cv::Vec3b());
  photo.seen(InPhoto(unseen)).setTo(0);
  const cv::Mat1f smoothed = Smoothed(values, photo);
  CHECK(cv::countNonZero(smoothed(unknown) == smoothed(unknown)) == 0);
  CHECK(cv::norm(smoothed(unseen), values(unseen), cv::NORM_INF) == 0.0);
  CHECK(std::abs(smoothed(12, 9) - 1.0f) < 0.2f);
  CHECK(cv::norm(Smoothed(values(unseen), {}), values(unseen), cv::NORM_INF) == 0.0);
}

TEST_CASE("guided filter: a large map is filtered as its parts are") {
  const cv::Mat1f values = NoiseAroundOne({20, 600});
  Orthophoto photo = EvenPhoto(values.size());
  const cv::Mat1f whole = Smoothed(values, photo);
  const cv::Range rows(200, 420), inside(40, 180);
  Orthophoto part;
  part.image = photo.image.rowRange(rows.start * kPhotoCellsPerCell, rows.end * kPhotoCellsPerCell);
  part.seen = photo.seen.rowRange(rows.start * kPhotoCellsPerCell, rows.end * kPhotoCellsPerCell);
  const cv::Mat1f smoothed = Smoothed(values.rowRange(rows).clone(), part);
  CHECK(cv::norm(smoothed.rowRange(inside), whole.rowRange(rows).rowRange(inside), cv::NORM_INF) <
        1e-5);
}

}  // namespace
}  // namespace freelsd
