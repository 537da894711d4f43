#include "tests/evaluation/frames/tile_measures.h"

#include <cmath>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr size_t kGreyLevel = kBands.size();
// Noise in shadows is no texture.
constexpr double kLogOffset = 4.0;

cv::Mat1f BoxSum(const cv::Mat1f& values, int side_px) {
  cv::Mat1f sum;
  cv::boxFilter(values,
                sum,
                CV_32F,
                {side_px, side_px},
                {-1, -1},
                false,
                cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
  return sum;
}

cv::Mat1f BoxMean(const cv::Mat1f& values, const cv::Mat1f& weights, int side_px) {
  cv::Mat1f mean;
  cv::divide(BoxSum(values.mul(weights), side_px), BoxSum(weights, side_px), mean);
  return mean;
}

// Of one picture.
class TileMeter {
 public:
  explicit TileMeter(const LabelledPicture& picture)
      : picture_(picture), log_brightness_(LogBrightness(picture.image)) {}

  // Bands of all that lies inside.
  std::array<cv::Mat1f, kBands.size()> BandsOf(const cv::Mat1b& inside) const {
    std::array<cv::Mat1f, kBands.size()> bands;
    for (size_t i = 0; i < kBands.size(); ++i) {
      bands[i] = BandOf(log_brightness_, inside, kBands[i], picture_.ground_sampling_m);
    }
    return bands;
  }

  Measures Of(const cv::Rect& tile, const std::array<cv::Mat1f, kBands.size()>& bands) const {
    Measures measures{};
    cv::Scalar mean, deviation;
    for (size_t i = 0; i < kBands.size(); ++i) {
      cv::meanStdDev(bands[i](tile), mean, deviation);
      measures[i] = deviation[0];
    }
    const cv::Scalar color = cv::mean(picture_.image(tile));
    measures[kGreyLevel] = 0.114 * color[0] + 0.587 * color[1] + 0.299 * color[2];
    return measures;
  }

 private:
  const LabelledPicture& picture_;
  cv::Mat1f log_brightness_;
};

}  // namespace

void TileOptions::Check() const {
  if (!(ground_sampling_m >= 0.05 && ground_sampling_m <= 0.3)) {
    throw std::invalid_argument("frames.ground_sampling_m = " + std::to_string(ground_sampling_m) +
                                ": must be in [0.05, 0.3]");
  }
  if (!(tile_m >= 2.0 && tile_m <= 40.0)) {
    throw std::invalid_argument("frames.tile_m = " + std::to_string(tile_m) +
                                ": must be in [2, 40]");
  }
}

int BoxSidePx(double size_m, double ground_sampling_m) {
  return 2 * static_cast<int>(std::lround(0.5 * (size_m / ground_sampling_m - 1.0))) + 1;
}

cv::Mat1f LogBrightness(const cv::Mat3b& image) {
  cv::Mat1b grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::Mat1f log_brightness;
  grey.convertTo(log_brightness, CV_32F, 1.0, kLogOffset);
  cv::log(log_brightness, log_brightness);
  return log_brightness;
}

cv::Mat1f BandOf(const cv::Mat1f& log_brightness,
                 const cv::Mat1b& inside,
                 const Band& band,
                 double ground_sampling_m) {
  cv::Mat1f weights;
  inside.convertTo(weights, CV_32F, 1.0 / 255.0);
  const cv::Mat1f fine =
      BoxMean(log_brightness, weights, BoxSidePx(band.fine_m, ground_sampling_m));
  const cv::Mat1f coarse =
      BoxMean(log_brightness, weights, BoxSidePx(band.coarse_m, ground_sampling_m));
  cv::Mat1f difference = fine - coarse;
  difference.setTo(0.0f, inside == 0);
  return difference;
}

const std::array<std::string, kNumMeasures>& MeasureNames() {
  static const std::array<std::string, kNumMeasures> kNames{"contrast 0.3-0.6 m",
                                                            "contrast 0.6-1.2 m",
                                                            "contrast 1.2-2.5 m",
                                                            "contrast 2.5-5 m",
                                                            "grey level"};
  return kNames;
}

std::map<Cover, std::vector<Measures>> MeasureTiles(const LabelledPicture& picture,
                                                    const TileOptions& options) {
  const TileMeter meter(picture);
  const int side_px = cvRound(options.tile_m / picture.ground_sampling_m);
  std::map<Cover, std::vector<Measures>> measures;
  for (const Cover cover : kComparedCovers) {
    const cv::Mat1b inside = InsideOf(picture, cover, options.margin_m);
    const std::vector<cv::Rect> tiles =
        TilesWithin(inside, side_px, options.max_num_tiles_per_picture);
    if (tiles.empty()) continue;
    const auto bands = meter.BandsOf(inside);
    for (const cv::Rect& tile : tiles) measures[cover].push_back(meter.Of(tile, bands));
  }
  return measures;
}

}  // namespace freelsd
