#include "engine/segmentation/area_resize.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Source pixels that a pixel of the result covers along one axis, and how much each counts.
std::vector<std::pair<int, float>> CoverOf(int index, double scale, int source_length) {
  constexpr double kLeastShare = 1e-3;
  const double from = index * scale, to = from + scale;
  std::vector<std::pair<int, float>> cover;
  for (int i = static_cast<int>(from); i < std::min(to, 1.0 * source_length); ++i) {
    const double share = std::min(i + 1.0, to) - std::max(1.0 * i, from);
    if (share > kLeastShare) cover.emplace_back(i, static_cast<float>(share / scale));
  }
  return cover;
}

// Down the columns, then along the row, in single precision.
uint8_t PlainMean(const cv::Mat& image, cv::Size size, const cv::Point& place, int channel) {
  const double rows_per_row = static_cast<double>(image.rows) / size.height;
  const double cols_per_col = static_cast<double>(image.cols) / size.width;
  float mean = 0.0f;
  for (const auto& [col, col_weight] : CoverOf(place.x, cols_per_col, image.cols)) {
    float sum = 0.0f;
    for (const auto& [row, row_weight] : CoverOf(place.y, rows_per_row, image.rows)) {
      sum += row_weight *
             static_cast<float>(image.ptr<uint8_t>(row)[col * image.channels() + channel]);
    }
    mean += col_weight * sum;
  }
  return static_cast<uint8_t>(std::nearbyint(mean));
}

cv::Mat PlainlyReduced(const cv::Mat& image, cv::Size size) {
  cv::Mat reduced(size, image.type());
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      for (int channel = 0; channel < image.channels(); ++channel) {
        reduced.ptr<uint8_t>(y)[x * image.channels() + channel] =
            PlainMean(image, size, {x, y}, channel);
      }
    }
  }
  return reduced;
}

TEST_CASE("area resize: plain loops give the same bytes") {
  cv::RNG random(5);
  const std::pair<cv::Size, std::vector<cv::Size>> pairs[] = {
      {{301, 192}, {{216, 138}, {108, 69}, {300, 191}}},
      {{97, 61}, {{97, 61}, {50, 60}, {8, 8}, {13, 1}, {1, 1}}},
      {{201, 1}, {{77, 1}, {1, 1}}},
      {{1, 90}, {{1, 33}}}};
  for (const int type : {CV_8UC1, CV_8UC3}) {
    for (const auto& [source, sizes] : pairs) {
      cv::Mat image(source, type);
      random.fill(image, cv::RNG::UNIFORM, 0, 256);
      for (const cv::Size& size : sizes) {
        CAPTURE(image.size());
        CAPTURE(size);
        const cv::Mat expected = PlainlyReduced(image, size);
        CHECK(cv::norm(ReduceByArea(image, size), expected, cv::NORM_INF) == 0.0);
      }
    }
  }
}

TEST_CASE("area resize: black stays black and white stays white") {
  for (const int level : {0, 255}) {
    const cv::Mat3b image(481, 753, cv::Vec3b::all(static_cast<uint8_t>(level)));
    for (const cv::Size size : {cv::Size(538, 344), {271, 171}, {9, 7}}) {
      const cv::Mat3b expected(size, cv::Vec3b::all(static_cast<uint8_t>(level)));
      CHECK(cv::norm(ReduceByArea(image, size), expected, cv::NORM_INF) == 0.0);
    }
  }
}

TEST_CASE("area resize: OpenCV's result within one grey level, and the same nearly everywhere") {
  cv::RNG random(3);
  for (const int type : {CV_8UC1, CV_8UC3}) {
    cv::Mat image(481, 752, type);
    random.fill(image, cv::RNG::UNIFORM, 0, 256);
    for (const cv::Size size : {cv::Size(538, 344), {269, 172}, {752, 481}, {376, 241}, {8, 9}}) {
      cv::Mat expected;
      cv::resize(image, expected, size, 0.0, 0.0, cv::INTER_AREA);
      const cv::Mat reduced = ReduceByArea(image, size);
      REQUIRE(reduced.size() == expected.size());
      REQUIRE(reduced.type() == type);
      CHECK(cv::norm(reduced, expected, cv::NORM_INF) <= 1.0);
      const double share = cv::norm(reduced, expected, cv::NORM_L1) /
                           static_cast<double>(reduced.total() * reduced.elemSize());
      constexpr double kMaxShareOfOtherRounding = 1e-3;
      CHECK(share < kMaxShareOfOtherRounding);
    }
  }
}

TEST_CASE("area resize: an image that is part of a larger one is read by its own rows") {
  cv::Mat3b large(60, 80);
  cv::RNG(4).fill(large, cv::RNG::UNIFORM, 0, 256);
  const cv::Rect part(11, 7, 50, 40);
  const cv::Mat reduced = ReduceByArea(large(part), {31, 25});
  CHECK(cv::norm(reduced, ReduceByArea(large(part).clone(), {31, 25}), cv::NORM_INF) == 0.0);
}

}  // namespace
}  // namespace freelsd
