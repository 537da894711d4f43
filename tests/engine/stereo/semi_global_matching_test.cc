#include "engine/stereo/semi_global_matching.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

struct ImagePair {
  cv::Mat1b left, right;
  // Left column minus right column, of the left image.
  cv::Mat1f disparity_px;
};

// Blobs of all sizes over a surface with steps and a slope; the noise of the two is independent.
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
  cv::Mat1f disparity_px(size), table_x(size), table_y(size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const float step = (x / 50 + y / 40) % 3 == 0 ? 4.0F : 0.0F;
      const float slope = 0.03F * static_cast<float>(x + y);
      disparity_px(y, x) = static_cast<float>(offset_px) + step + slope;
      table_x(y, x) = static_cast<float>(x + 200) - disparity_px(y, x);
      table_y(y, x) = static_cast<float>(y);
    }
  }
  cv::Mat1f left;
  cv::remap(ground, left, table_x, table_y, cv::INTER_LINEAR);
  return {noisy(left), noisy(ground.colRange(200, 200 + size.width)), disparity_px};
}

SemiGlobalOptions Options(int min_disparity_px, int num_disparities, int block_size_px = 7) {
  const int area = block_size_px * block_size_px;
  return {min_disparity_px, num_disparities, block_size_px, 8 * area, 32 * area, 1, 15, 100, 2};
}

// Share of the pixels whose disparity lies in the range and in the right image that are matched,
// and of the matched ones that are matched within a pixel.
struct Quality {
  double matched = 0.0;
  double right = 0.0;
};

Quality QualityOf(const cv::Mat1s& sixteenths,
                  const ImagePair& pair,
                  const SemiGlobalOptions& options) {
  int num_matchable = 0, num_matched = 0, num_right = 0;
  const int first_x = std::max(0, options.min_disparity_px + options.num_disparities);
  for (int y = 0; y < sixteenths.rows; ++y) {
    for (int x = first_x; x < sixteenths.cols; ++x) {
      const float truth = pair.disparity_px(y, x);
      if (static_cast<float>(x) - truth >= static_cast<float>(sixteenths.cols)) continue;
      ++num_matchable;
      if (sixteenths(y, x) < options.min_disparity_px * kDisparityUnit) continue;
      ++num_matched;
      num_right += std::abs(sixteenths(y, x) / 16.0F - truth) < 1.0F;
    }
  }
  return {num_matched / (num_matchable + 1e-9), num_right / (num_matched + 1e-9)};
}

Quality QualityOf(const ImagePair& pair, const SemiGlobalOptions& options) {
  const cv::Mat1s sixteenths = MatchSemiGlobally(pair.left, pair.right, options);
  REQUIRE(sixteenths.size() == pair.left.size());
  return QualityOf(sixteenths, pair, options);
}

Quality QualityOfOpenCv(const ImagePair& pair, const SemiGlobalOptions& options) {
  cv::Mat1s sixteenths;
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
      ->compute(pair.left, pair.right, sixteenths);
  return QualityOf(sixteenths, pair, options);
}

// How much worse than OpenCV's either share may be: three paths, the same costs.
constexpr double kMaxWorse = 0.01;

void CheckNoWorseThanOpenCv(const ImagePair& pair, const SemiGlobalOptions& options) {
  const Quality ours = QualityOf(pair, options), others = QualityOfOpenCv(pair, options);
  CHECK(ours.matched > others.matched - kMaxWorse);
  CHECK(ours.right > others.right - kMaxWorse);
}

TEST_CASE("semi-global matching: a surface with steps and a slope, wherever its disparities lie") {
  for (const int offset_px : {-60, -20, 0, 30}) {
    CAPTURE(offset_px);
    const ImagePair pair = Terrain({320, 240}, offset_px, 40.0, 1.0);
    const Quality quality = QualityOf(pair, Options(offset_px - 8, 48));
    CHECK(quality.matched > 0.85);
    CHECK(quality.right > 0.98);
  }
}

TEST_CASE("semi-global matching: no worse than OpenCV's, for any number of disparities") {
  const ImagePair pair = Terrain({700, 90}, 0, 40.0, 2.0);
  for (const int num_disparities : {32, 48, 112, 256, 272, 512}) {
    CAPTURE(num_disparities);
    CheckNoWorseThanOpenCv(pair, Options(-num_disparities / 3, num_disparities));
  }
}

TEST_CASE("semi-global matching: a surface is found with blocks whose sums lose bits") {
  const ImagePair pair = Terrain({320, 240}, 0, 40.0, 2.0);
  for (const int block_size_px : {3, 5, 7, 9, 11, 15, 21}) {
    CAPTURE(block_size_px);
    const Quality quality = QualityOf(pair, Options(-8, 48, block_size_px));
    CHECK(quality.matched > 0.7);
    CHECK(quality.right > 0.9);
  }
}

TEST_CASE("semi-global matching: no penalty is too large for the sums") {
  const ImagePair pair = Terrain({320, 120}, 0, 40.0, 1.0);
  for (const int p2 : {2, 500, 6000, 30000, 2000000000}) {
    CAPTURE(p2);
    SemiGlobalOptions options = Options(-8, 32);
    options.p1 = p2 / 2;
    options.p2 = p2;
    CHECK(QualityOf(pair, options).right > 0.9);
  }
}

TEST_CASE("semi-global matching: exposed alike, burnt out or noisy, no worse than OpenCV's") {
  for (const double contrast : {5.0, 40.0, 400.0}) {
    for (const double noise_sd_grey : {0.0, 4.0, 15.0}) {
      CAPTURE(contrast);
      CAPTURE(noise_sd_grey);
      CheckNoWorseThanOpenCv(Terrain({320, 160}, 5, contrast, noise_sd_grey), Options(-8, 64));
    }
  }
}

TEST_CASE("semi-global matching: the number of threads changes no byte") {
  const ImagePair pair = Terrain({259, 130}, 0, 40.0, 4.0);
  const int num_threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const cv::Mat1s one = MatchSemiGlobally(pair.left, pair.right, Options(-16, 64));
  cv::setNumThreads(4);
  const cv::Mat1s four = MatchSemiGlobally(pair.left, pair.right, Options(-16, 64));
  cv::setNumThreads(num_threads);
  CHECK(cv::countNonZero(one != four) == 0);
}

TEST_CASE("semi-global matching: without contrast nothing is matched") {
  const cv::Mat1b even(90, 180, uint8_t{120});
  const SemiGlobalOptions options = Options(-20, 48);
  const int unmatched = (options.min_disparity_px - 1) * kDisparityUnit;
  CHECK(cv::countNonZero(MatchSemiGlobally(even, even, options) != unmatched) == 0);
}

TEST_CASE("semi-global matching: images of few rows, and hardly wide enough or not at all") {
  for (const int num_rows : {1, 2, 5, 10, 21, 41}) {
    CAPTURE(num_rows);
    const ImagePair pair = Terrain({160, num_rows}, 0, 40.0, 1.0);
    SemiGlobalOptions options = Options(-8, 32);
    options.speckle_size_px = 0;
    if (num_rows >= 10) CHECK(QualityOf(pair, options).right > 0.9);
    CHECK(MatchSemiGlobally(pair.left, pair.right, options).size() == pair.left.size());
  }
  for (const int width_px : {3, 31, 32, 33, 40, 63}) {
    CAPTURE(width_px);
    const ImagePair pair = Terrain({width_px, 40}, 0, 40.0, 1.0);
    CHECK(MatchSemiGlobally(pair.left, pair.right, Options(-8, 32)).size() == pair.left.size());
    CHECK(MatchSemiGlobally(pair.left, pair.right, Options(0, 32)).size() == pair.left.size());
  }
}

}  // namespace
}  // namespace freelsd
