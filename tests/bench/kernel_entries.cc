// Kernels of our own, each beside OpenCV's call for the same. One that is not 1.5 times as fast on
// one core is not worth its lines.
#include <cmath>
#include <stdexcept>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/segmentation/area_resize.h"
#include "engine/segmentation/edge_distance.h"
#include "engine/stereo/rectification.h"
#include "engine/stereo/semi_global_matching.h"
#include "engine/tracks/corners.h"
#include "tests/bench/bench_scene.h"
#include "tests/bench/contest.h"

namespace freelsd {
namespace {

cv::Mat1b GreyTexture(const cv::Mat& image) {
  cv::Mat1b grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

// As the tracker asks for them.
Contest Corners(const BenchScene& scene) {
  constexpr double kQuality = 0.01;
  const cv::Mat1b grey = GreyTexture(scene.frames[5].image);
  const int count = scene.options.tracks.max_num_corners;
  const double spacing_px = 0.5 * std::sqrt(static_cast<double>(grey.total()) / count);
  const cv::Mat1b mask(grey.size(), uint8_t{255});
  return {"kernel_corners",
          SizeOf(grey),
          [=] {
            Consume(static_cast<double>(
                StrongestCorners(grey, {mask, count, kQuality, spacing_px}).size()));
          },
          "goodFeaturesToTrack, the same corners",
          [=] {
            std::vector<cv::Point2f> corners;
            cv::goodFeaturesToTrack(grey, corners, count, kQuality, spacing_px, mask);
            Consume(static_cast<double>(corners.size()));
          }};
}

// To the sizes of the classification and of the segmentation.
Contest AreaResize(const BenchScene& scene, cv::Size size) {
  const cv::Mat image = scene.frames[5].image;
  return {"kernel_area_resize",
          SizeOf(image) + " to " + std::to_string(size.width) + "x" + std::to_string(size.height),
          [=] { Consume(ReduceByArea(image, size).at<cv::Vec3b>(0, 0)[0]); },
          "resize with INTER_AREA, the same but for rounding",
          [=] {
            cv::Mat reduced;
            cv::resize(image, reduced, size, 0.0, 0.0, cv::INTER_AREA);
            Consume(reduced.at<cv::Vec3b>(0, 0)[0]);
          }};
}

Contest EdgeDistance(const BenchScene& scene) {
  constexpr double kCannyHigh = 120.0;
  // 1 m, seen from 100 m at 0.6 m a pixel.
  constexpr double kDistancePx = 1.67;
  cv::Mat1b grey = GreyTexture(ReduceByArea(scene.frames[5].image, {269, 172})), edges;
  cv::Canny(grey, edges, kCannyHigh / 3.0, kCannyHigh);
  return {"kernel_edge_distance",
          SizeOf(edges),
          [=] { Consume(FarFromEdges(edges, kDistancePx)(0, 0)); },
          "distanceTransform with DIST_MASK_5 and a threshold, the same pixels",
          [=] {
            cv::Mat1f distance_px;
            cv::distanceTransform(~edges, distance_px, cv::DIST_L2, cv::DIST_MASK_5);
            const cv::Mat1b is_far = distance_px > kDistancePx;
            Consume(is_far(0, 0));
          }};
}

Contest SemiGlobalMatching(const BenchScene& scene) {
  const StereoOptions& stereo = scene.options.stereo;
  const auto pair = RectifyPair(scene.block,
                                scene.pair,
                                scene.frames[scene.pair.left].image,
                                scene.frames[scene.pair.right].image,
                                stereo);
  if (!pair) throw std::runtime_error("the pair to measure on cannot be rectified");
  constexpr int kNumDisparities = 80;
  const int area = stereo.block_size_px * stereo.block_size_px;
  const SemiGlobalOptions options{-kNumDisparities / 2,
                                  kNumDisparities,
                                  stereo.block_size_px,
                                  stereo.p1_factor * area,
                                  stereo.p2_factor * area,
                                  stereo.max_left_right_difference_px,
                                  stereo.uniqueness_ratio_percent,
                                  stereo.speckle_size_px,
                                  2};
  return {"kernel_semi_global",
          SizeOf(pair->left) + ", 80 disparities",
          [=] { Consume(MatchSemiGlobally(pair->left, pair->right, options)(0, 0)); },
          "StereoSGBM of 3 directions, the same but for ties",
          [=] {
            cv::Mat1s disparity;
            cv::StereoSGBM::create(options.min_disparity_px,
                                   options.num_disparities,
                                   options.block_size_px,
                                   options.p1,
                                   options.p2,
                                   options.max_left_right_difference_px,
                                   0,
                                   options.uniqueness_ratio_percent,
                                   options.speckle_size_px,
                                   options.speckle_range_px,
                                   cv::StereoSGBM::MODE_SGBM_3WAY)
                ->compute(pair->left, pair->right, disparity);
            Consume(disparity(0, 0));
          }};
}

}  // namespace

std::vector<Entry> KernelEntries(const std::string& model_file) {
  return {
      {"kernel_corners", [=] { return Corners(Scene(model_file)); }},
      {"kernel_area_resize",
       [=] {
         return AreaResize(Scene(model_file), {538, 344});
       }},
      {"kernel_area_resize",
       [=] {
         return AreaResize(Scene(model_file), {269, 172});
       }},
      {"kernel_edge_distance", [=] { return EdgeDistance(Scene(model_file)); }},
      {"kernel_semi_global", [=] { return SemiGlobalMatching(Scene(model_file)); }},
  };
}

}  // namespace freelsd
