#include "engine/segmentation/edge_distance.h"

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

cv::Mat1b ByDistanceTransform(const cv::Mat1b& edges, double distance_px) {
  cv::Mat1f edge_distance_px;
  cv::distanceTransform(~edges, edge_distance_px, cv::DIST_L2, cv::DIST_MASK_5);
  return edge_distance_px > distance_px;
}

cv::Mat1b RandomEdges(cv::Size size, double share, cv::RNG& random) {
  cv::Mat1d numbers(size);
  random.fill(numbers, cv::RNG::UNIFORM, 0.0, 1.0);
  return numbers < share;
}

bool AreEqual(const cv::Mat1b& a, const cv::Mat1b& b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

constexpr double kDistancesPx[] = {-1.0,   0.0,  0.3,    1.0,   1.2,   1.4,  1.7,  2.0,
                                   2.1969, 2.3,  2.9999, 4.39,  5.0,   7.77, 11.0, 19.5,
                                   33.3,   57.0, 100.5,  253.9, 254.0, 255., 300.0};

TEST_CASE("edge distance: the pixels that the distance transform calls far") {
  cv::RNG random(11);
  for (const cv::Size size : {cv::Size(269, 172), {97, 61}, {33, 1}, {1, 70}, {1, 1}, {5, 3}}) {
    for (const double share : {0.0, 1e-4, 2e-3, 0.03, 0.3, 1.0}) {
      const cv::Mat1b edges = RandomEdges(size, share, random);
      for (const double distance_px : kDistancesPx) {
        CAPTURE(size);
        CAPTURE(share);
        CAPTURE(distance_px);
        CHECK(AreEqual(FarFromEdges(edges, distance_px), ByDistanceTransform(edges, distance_px)));
      }
    }
  }
}

TEST_CASE("edge distance: one edge in a corner, or only beyond where rows are counted") {
  for (const cv::Point& place : {cv::Point(0, 0), {79, 0}, {0, 599}, {40, 300}}) {
    cv::Mat1b edges(600, 80, uint8_t{0});
    edges(place) = 255;
    for (const double distance_px : kDistancesPx) {
      CAPTURE(place);
      CAPTURE(distance_px);
      CHECK(AreEqual(FarFromEdges(edges, distance_px), ByDistanceTransform(edges, distance_px)));
    }
  }
}

TEST_CASE("edge distance: as a float 4.99999999 is 5, and farther than any pixel none is far") {
  cv::Mat1b edges(40, 50, uint8_t{0});
  edges(20, 20) = 255;
  for (const double distance_px : {4.99999999, 4.9999, 9000.0, 1e9}) {
    CAPTURE(distance_px);
    CHECK(AreEqual(FarFromEdges(edges, distance_px), ByDistanceTransform(edges, distance_px)));
  }
}

}  // namespace
}  // namespace freelsd
