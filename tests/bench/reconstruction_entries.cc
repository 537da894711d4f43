// From images to points, and what one would write with OpenCV or a plain loop for each.
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/stereo/matching.h"
#include "tests/bench/bench_scene.h"
#include "tests/bench/contest.h"

namespace freelsd {
namespace {

// Rectified by OpenCV and matched by its slower, better mode, as aerial_mapper sets it.
double PlainStereo(const cv::Mat& left,
                   const cv::Mat& right,
                   const cv::Mat& map_x,
                   const cv::Mat& map_y) {
  constexpr int kNumDisparities = 80, kBlockPx = 9;
  cv::Mat1b grey[2];
  const cv::Mat* images[2] = {&left, &right};
  for (int i = 0; i < 2; ++i) {
    cv::Mat rectified;
    cv::remap(*images[i], rectified, map_x, map_y, cv::INTER_LINEAR);
    cv::cvtColor(rectified, grey[i], cv::COLOR_BGR2GRAY);
  }
  const auto matcher = cv::StereoSGBM::create(
      1, kNumDisparities, kBlockPx, 120, 250, 0, 35, 10, 100, 20, cv::StereoSGBM::MODE_SGBM);
  cv::Mat disparity, points;
  matcher->compute(grey[0], grey[1], disparity);
  cv::reprojectImageTo3D(disparity, points, cv::Mat::eye(4, 4, CV_64F));
  return points.at<cv::Vec3f>(0, 0)[2];
}

Contest Stereo(const BenchScene& scene) {
  const cv::Mat left = scene.frames[scene.pair.left].image;
  const cv::Mat right = scene.frames[scene.pair.right].image;
  cv::Mat1f map_x(left.size()), map_y(left.size());
  for (int row = 0; row < left.rows; ++row) {
    for (int col = 0; col < left.cols; ++col) {
      map_x(row, col) = static_cast<float>(col) + 0.25f;
      map_y(row, col) = static_cast<float>(row) + 0.25f;
    }
  }
  return {
      "stereo",
      SizeOf(left),
      [=, &scene] {
        Consume(static_cast<double>(
            ReconstructPoints(scene.block, scene.pair, left, right, scene.options.stereo).size()));
      },
      "remap twice, StereoSGBM of 5 directions and 80 disparities, reprojectImageTo3D",
      [=] { Consume(PlainStereo(left, right, map_x, map_y)); }};
}

// OpenCV's slower, better mode on a rectified pair, in pixels; NaN where it has no answer.
cv::Mat1f PlainMatch(const RectifiedPair& pair) {
  // Typical depth has disparity 0.
  constexpr int kNumDisparities = 80, kBlockPx = 9;
  constexpr int kMinDisparity = -kNumDisparities / 2;
  const auto matcher = cv::StereoSGBM::create(kMinDisparity,
                                              kNumDisparities,
                                              kBlockPx,
                                              8 * kBlockPx * kBlockPx,
                                              32 * kBlockPx * kBlockPx,
                                              1,
                                              0,
                                              10,
                                              100,
                                              2,
                                              cv::StereoSGBM::MODE_SGBM);
  cv::Mat1s sixteenths;
  matcher->compute(pair.left, pair.right, sixteenths);
  cv::Mat1f disparity_px(sixteenths);
  disparity_px /= 16.0f;
  disparity_px.setTo(std::numeric_limits<float>::quiet_NaN(), sixteenths < kMinDisparity * 16);
  return disparity_px;
}

// Share of the left image that has an answer, and how far the points are from the world's surface.
std::string QualityOf(const cv::Mat1f& disparity_px,
                      const RectifiedPair& pair,
                      const World& world) {
  std::vector<double> errors;
  for (int v = 0; v < disparity_px.rows; ++v) {
    for (int u = 0; u < disparity_px.cols; ++u) {
      if (std::isnan(disparity_px(v, u))) continue;
      const Eigen::Vector3d ray(
          (u - pair.left_cx_px) / pair.focal_px, (v - pair.cy_px) / pair.focal_px, 1.0);
      const Eigen::Vector3d point = pair.world_from_left * (ray * pair.DepthOf(disparity_px(v, u)));
      errors.push_back(std::abs(point.z() - world.SurfaceHeight(point.x(), point.y())));
    }
  }
  if (errors.empty()) return "no answer";
  std::sort(errors.begin(), errors.end());
  std::ostringstream text;
  text << std::fixed << std::setprecision(2)
       << static_cast<double>(errors.size()) / cv::countNonZero(pair.is_left_inside)
       << " valid, height error median " << errors[errors.size() / 2] << " m, 90 % within "
       << errors[errors.size() * 9 / 10] << " m";
  return text.str();
}

Contest StereoMatching(const BenchScene& scene) {
  const StereoOptions& options = scene.options.stereo;
  const auto pair = RectifyPair(scene.block,
                                scene.pair,
                                scene.frames[scene.pair.left].image,
                                scene.frames[scene.pair.right].image,
                                options);
  if (!pair) throw std::runtime_error("the pair to measure on cannot be rectified");
  const DepthRange depths = DepthsOf(scene.block, scene.pair, options);
  return {"stereo_matching",
          SizeOf(pair->left),
          [=] { Consume(MatchRectified(*pair, depths, options)(0, 0)); },
          "StereoSGBM of 5 directions and 80 disparities",
          [=] { Consume(PlainMatch(*pair)(0, 0)); },
          1.0,
          "engine: " + QualityOf(MatchRectified(*pair, depths, options), *pair, *scene.world) +
              "; plain: " + QualityOf(PlainMatch(*pair), *pair, *scene.world)};
}

// Per view. OpenCV has no adjustment of cameras that move.
Contest Adjustment(const BenchScene& scene, const std::vector<View>& views) {
  const Camera& camera = scene.rig.camera;
  const AdjustmentOptions& options = scene.options.adjustment;
  const AdjustedBlock block = AdjustPoses(views, camera, options);
  return {"bundle_adjustment",
          std::to_string(views.size()) + " views, " + std::to_string(block.landmarks.size()) +
              " landmarks",
          [=] { Consume(AdjustPoses(views, camera, options).rms_after_px); },
          "",
          {},
          static_cast<double>(views.size())};
}

// Ten views with about 500 landmarks: the size that others are measured at.
Contest SmallAdjustment(const BenchScene& scene) {
  constexpr int kNumViews = 10, kNumTracksPerView = 170;
  const std::vector<View>& views = scene.snapshot.views;
  return Adjustment(
      scene,
      WithLongestTracks(
          {views.begin(), views.begin() + kNumViews}, scene.rig.camera, kNumTracksPerView));
}

}  // namespace

std::vector<Entry> ReconstructionEntries(const std::string& model_file) {
  return {
      {"bundle_adjustment",
       [=] { return Adjustment(Scene(model_file), Scene(model_file).snapshot.views); }},
      {"bundle_adjustment", [=] { return SmallAdjustment(Scene(model_file)); }},
      {"stereo_matching", [=] { return StereoMatching(Scene(model_file)); }},
      {"stereo", [=] { return Stereo(Scene(model_file)); }},
  };
}

}  // namespace freelsd
