#include "engine/stereo/semi_global_matching.h"

#include <algorithm>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

struct ImagePair {
  cv::Mat1b left, right;
};

// Blobs of all sizes over a surface with steps and a slope; `noise_sd_grey` differs between the
// two.
ImagePair Terrain(cv::Size size, int offset_px, double contrast, double noise_sd_grey) {
  cv::RNG random(static_cast<uint64_t>(size.width * 1000 + size.height));
  cv::Mat1f ground(size.height, size.width + 400, 0.0F);
  for (const int cell_px : {1, 3, 9, 40}) {
    cv::Mat1f cells(size.height / cell_px + 2, ground.cols / cell_px + 2), blobs;
    random.fill(cells, cv::RNG::UNIFORM, -1.0, 1.0);
    cv::resize(cells, blobs, ground.size(), 0, 0, cv::INTER_CUBIC);
    ground += blobs;
  }
  const auto noisy = [&](const cv::Mat1f& image) {
    cv::Mat1f noise(image.size());
    random.fill(noise, cv::RNG::NORMAL, 0.0, noise_sd_grey);
    cv::Mat1b grey;
    cv::Mat1f(image * contrast + noise).convertTo(grey, CV_8U, 1.0, 128.0);
    return grey;
  };
  cv::Mat1f table_x(size), table_y(size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const float step = (x / 50 + y / 40) % 3 == 0 ? 4.0F : 0.0F;
      const float slope = 0.03F * static_cast<float>(x + y);
      table_x(y, x) = static_cast<float>(x + 200 - offset_px) - step - slope;
      table_y(y, x) = static_cast<float>(y);
    }
  }
  cv::Mat1f left;
  cv::remap(ground, left, table_x, table_y, cv::INTER_LINEAR);
  return {noisy(left), noisy(ground.colRange(200, 200 + size.width))};
}

cv::Mat1s OfOpenCv(const ImagePair& pair, const SemiGlobalOptions& options) {
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
      ->compute(pair.left, pair.right, disparity);
  return disparity;
}

SemiGlobalOptions Options(int min_disparity_px, int num_disparities, int block_size_px = 7) {
  const int area = block_size_px * block_size_px;
  return {min_disparity_px, num_disparities, block_size_px, 8 * area, 32 * area, 1, 15, 100, 2};
}

int NumDifferent(const ImagePair& pair, const SemiGlobalOptions& options) {
  const cv::Mat1s ours = MatchSemiGlobally(pair.left, pair.right, options);
  REQUIRE(ours.size() == pair.left.size());
  return cv::countNonZero(ours != OfOpenCv(pair, options));
}

double MatchedShare(const ImagePair& pair, const SemiGlobalOptions& options) {
  const cv::Mat1s disparity = MatchSemiGlobally(pair.left, pair.right, options);
  return cv::countNonZero(disparity >= options.min_disparity_px * kDisparityUnit) /
         static_cast<double>(disparity.total());
}

TEST_CASE("semi-global matching: disparities are those of OpenCV, of images of any size") {
  for (const cv::Size size : {cv::Size(320, 240), cv::Size(161, 97), cv::Size(203, 66)}) {
    for (const int num_disparities : {16, 32, 48, 64, 112}) {
      CAPTURE(size.width);
      CAPTURE(num_disparities);
      const ImagePair pair = Terrain(size, 0, 40.0, 1.0);
      CHECK(NumDifferent(pair, Options(-num_disparities / 3, num_disparities)) == 0);
    }
  }
  CHECK(MatchedShare(Terrain({320, 240}, 0, 40.0, 1.0), Options(-12, 48)) > 0.5);
}

TEST_CASE("semi-global matching: disparities are those of OpenCV, wherever their range lies") {
  const ImagePair pair = Terrain({259, 130}, 40, 40.0, 1.0);
  for (const int min_disparity_px : {-100, -64, -33, -16, -1, 0, 1, 30, 90}) {
    CAPTURE(min_disparity_px);
    CHECK(NumDifferent(pair, Options(min_disparity_px, 64)) == 0);
  }
}

TEST_CASE("semi-global matching: disparities are those of OpenCV, with any block") {
  const ImagePair pair = Terrain({200, 120}, 0, 40.0, 1.0);
  // From 11 on sums do not fit into 16 bits, and OpenCV is asked.
  for (const int block_size_px : {1, 3, 5, 7, 9, 11, 21}) {
    CAPTURE(block_size_px);
    CHECK(NumDifferent(pair, Options(-10, 48, block_size_px)) == 0);
  }
}

TEST_CASE("semi-global matching: disparities are those of OpenCV, with any thresholds") {
  const ImagePair pair = Terrain({200, 120}, 0, 40.0, 4.0);
  for (const int uniqueness_ratio_percent : {0, 1, 5, 40, 90, 99}) {
    for (const int max_difference_px : {0, 1, 3}) {
      CAPTURE(uniqueness_ratio_percent);
      CAPTURE(max_difference_px);
      SemiGlobalOptions options = Options(-10, 48);
      options.uniqueness_ratio_percent = uniqueness_ratio_percent;
      options.max_left_right_difference_px = max_difference_px;
      options.speckle_size_px = max_difference_px * 20;
      CHECK(NumDifferent(pair, options) == 0);
    }
  }
  for (const int p2 : {2, 50, 6000}) {
    CAPTURE(p2);
    SemiGlobalOptions options = Options(-10, 48);
    options.p1 = 1;
    options.p2 = p2;
    CHECK(NumDifferent(pair, options) == 0);
  }
}

TEST_CASE("semi-global matching: disparities are those of OpenCV where many cost the same") {
  const cv::Size size(180, 90);
  const cv::Mat1b even(size, uint8_t{120}), black(size, uint8_t{0}), white(size, uint8_t{255});
  ImagePair stripes{cv::Mat1b(size), {}}, half{even.clone(), even.clone()};
  for (int x = 0; x < size.width; ++x) stripes.left.col(x) = x / 2 % 4 == 0 ? 255 : 0;
  stripes.right = stripes.left;
  half.left.rowRange(0, 40) = Terrain({180, 40}, 0, 40.0, 1.0).left;
  half.right.rowRange(0, 40) = Terrain({180, 40}, 0, 40.0, 1.0).right;
  const std::vector<ImagePair> pairs{
      {even, even}, {black, white}, {white, black}, stripes, half, Terrain(size, 0, 1.0, 0.0)};
  for (size_t i = 0; i < pairs.size(); ++i) {
    for (const int uniqueness_ratio_percent : {0, 15}) {
      CAPTURE(i);
      CAPTURE(uniqueness_ratio_percent);
      SemiGlobalOptions options = Options(-20, 48);
      options.uniqueness_ratio_percent = uniqueness_ratio_percent;
      options.speckle_size_px = 0;
      CHECK(NumDifferent(pairs[i], options) == 0);
    }
  }
}

TEST_CASE("semi-global matching: disparities are those of OpenCV in burnt-out and noisy images") {
  for (const double contrast : {2.0, 400.0}) {
    for (const double noise_sd_grey : {0.0, 30.0}) {
      CAPTURE(contrast);
      CAPTURE(noise_sd_grey);
      CHECK(NumDifferent(Terrain({231, 100}, 5, contrast, noise_sd_grey), Options(-8, 64)) == 0);
    }
  }
}

TEST_CASE("semi-global matching: disparities are those of OpenCV in images hardly wide enough") {
  for (const int spare_px : {15, 16, 17, 30}) {
    for (const int num_disparities : {16, 80, 256}) {
      CAPTURE(spare_px);
      CAPTURE(num_disparities);
      const ImagePair pair = Terrain({num_disparities + spare_px, 70}, 0, 40.0, 1.0);
      CHECK(NumDifferent(pair, Options(-num_disparities / 2, num_disparities)) == 0);
    }
  }
}

TEST_CASE("semi-global matching: more disparities, and few rows, are left to OpenCV") {
  CHECK(NumDifferent(Terrain({330, 70}, 0, 40.0, 1.0), Options(-140, 272)) == 0);
  for (const int num_rows : {10, 21, 30, 41})
    CHECK(NumDifferent(Terrain({100, num_rows}, 0, 40.0, 1.0), Options(-8, 32)) == 0);
}

}  // namespace
}  // namespace freelsd
