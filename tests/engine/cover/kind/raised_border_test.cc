#include "engine/cover/kind/raised_border.h"

#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr int kNumCells = 120;  // of 1 m
constexpr double kSlope = 0.08;
// The field: a square in the middle, in cells from its centre.
constexpr int kFieldHalf = 25;

// Cells from the middle of the square to the nearest side: below zero outside of it.
int Within(int row, int col) {
  const int off = std::max(std::abs(row - kNumCells / 2), std::abs(col - kNumCells / 2));
  return kFieldHalf - off;
}

using HeightAt = std::function<double(int row, int col)>;

// Ground that falls to the south-east, with what stands on it.
cv::Mat1f Terrain(const HeightAt& stands) {
  cv::Mat1f elevation(kNumCells, kNumCells);
  for (int row = 0; row < kNumCells; ++row) {
    for (int col = 0; col < kNumCells; ++col) {
      elevation(row, col) = float(-kSlope * row - 0.5 * kSlope * col + stands(row, col));
    }
  }
  return elevation;
}

// What is even: all but the border of the field, which is rough on both of its sides.
cv::Mat1b Even() {
  cv::Mat1b even(kNumCells, kNumCells);
  for (int row = 0; row < kNumCells; ++row) {
    for (int col = 0; col < kNumCells; ++col) {
      even(row, col) = std::abs(Within(row, col)) > 1 ? 255 : 0;
    }
  }
  return even;
}

cv::Mat1f RatioOf(const HeightAt& stands) {
  return RaisedBorderRatio(Even(), Terrain(stands), 1.0);
}

float InTheMiddle(const cv::Mat1f& ratio) { return ratio(kNumCells / 2, kNumCells / 2); }

TEST_CASE("raised border: a crop stands above all around it, on a slope too") {
  const cv::Mat1f ratio =
      RatioOf([](int row, int col) { return Within(row, col) > 0 ? 1.2 : 0.0; });
  for (int row = 0; row < kNumCells; ++row) {
    for (int col = 0; col < kNumCells; ++col) {
      if (Within(row, col) > 5) CHECK(ratio(row, col) > 0.9f);
    }
  }
  CHECK(std::isnan(ratio(kNumCells / 2 - kFieldHalf, kNumCells / 2)));
}

TEST_CASE("raised border: level ground, a low crop and a hollow have none") {
  for (const double height : {0.0, 0.4, -1.2}) {
    CAPTURE(height);
    CHECK(InTheMiddle(RatioOf(
              [&](int row, int col) { return Within(row, col) > 0 ? height : 0.0; })) == 0.0f);
  }
}

TEST_CASE("raised border: a hedge or a ditch around a meadow does not raise it") {
  for (const double height : {2.0, -1.0}) {
    CAPTURE(height);
    CHECK_FALSE(InTheMiddle(RatioOf([&](int row, int col) {
                  return std::abs(Within(row, col)) <= 1 ? height : 0.0;
                })) > 0.1f);
  }
}

TEST_CASE("raised border: a terrace stands above its lower side alone") {
  CHECK(InTheMiddle(RatioOf(
            [](int row, int) { return row > kNumCells / 2 + kFieldHalf ? -1.5 : 0.0; })) < 0.3f);
}

TEST_CASE("raised border: what lies around must have been seen") {
  cv::Mat1f elevation = Terrain([](int row, int col) { return Within(row, col) > 0 ? 1.2 : 0.0; });
  for (int row = 0; row < kNumCells; ++row) {
    for (int col = 0; col < kNumCells; ++col) {
      if (Within(row, col) < 1) elevation(row, col) = std::numeric_limits<float>::quiet_NaN();
    }
  }
  CHECK(std::isnan(InTheMiddle(RaisedBorderRatio(Even(), elevation, 1.0))));
}

}  // namespace
}  // namespace freelsd
