// From images to points, and what one would write with OpenCV or a plain loop for each.
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

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

// Per view. OpenCV has no adjustment of cameras that move.
Contest Adjustment(const BenchScene& scene) {
  const size_t num_views = scene.snapshot.views.size();
  return {"bundle_adjustment",
          std::to_string(num_views) + " views, " + std::to_string(scene.block.landmarks.size()) +
              " landmarks",
          [&scene] {
            Consume(AdjustPoses(scene.snapshot.views, scene.rig.camera, scene.options.adjustment)
                        .rms_after_px);
          },
          "",
          {},
          static_cast<double>(num_views)};
}

}  // namespace

std::vector<Entry> ReconstructionEntries(const std::string& model_text) {
  return {
      {"bundle_adjustment", [=] { return Adjustment(Scene(model_text)); }},
      {"stereo", [=] { return Stereo(Scene(model_text)); }},
  };
}

}  // namespace freelsd
