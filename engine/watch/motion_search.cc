#include "engine/watch/motion_search.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"
#include "engine/watch/light_bands.h"

namespace freelsd {
namespace {

// Pixel of the search.
constexpr double kCoarsePixelM = 0.3;
// Surroundings against which a band becomes pattern.
constexpr double kPatternWindowM = 3.0;
constexpr double kPatternSmoothingPx = 0.7;
// Fainter patterns, in logarithms, are noise.
constexpr float kFaintestBrightness = 0.02f;
constexpr float kFaintestGreen = 0.03f;
// Weight of the pattern of green against that of brightness.
constexpr double kGreenShare = 0.7;
// Of the shifts, the most similar one may be wrong.
constexpr int kNumPeaks = 3;
constexpr int kPeakRadiusPx = 3;
// Loss of correlation at the largest shift: small pose errors are more likely.
constexpr double kFarShiftLoss = 0.25;

cv::Mat2f PatternsIn(const cv::Mat3f& picture, const cv::Mat1b& is_shown, int side_px) {
  cv::Mat3f reduced;
  cv::resize(picture, reduced, is_shown.size(), 0.0, 0.0, cv::INTER_AREA);
  // In the dark, the pattern of grass is hardly stronger than the noise of single pixels.
  cv::GaussianBlur(reduced, reduced, {}, kPatternSmoothingPx);
  const LightBands bands = BandsOf(reduced, 1.0);
  cv::Mat2f patterns;
  cv::merge(
      std::vector<cv::Mat1f>{
          PatternOf(bands.brightness, is_shown, side_px, kFaintestBrightness),
          kGreenShare * PatternOf(bands.green_excess, is_shown, side_px, kFaintestGreen)},
      patterns);
  return patterns;
}

cv::Mat1b ReducedMask(const cv::Mat1b& mask, const cv::Size& size) {
  cv::Mat1b reduced;
  cv::resize(mask, reduced, size, 0.0, 0.0, cv::INTER_AREA);
  return reduced == 255;
}

struct Shift {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double score = -1.0;
};

cv::Mat1f Correlated(const cv::Mat& image, const cv::Mat& pattern) {
  cv::Mat1f result;
  cv::matchTemplate(image, pattern, result, cv::TM_CCORR);
  return result;
}

std::vector<Shift> HighestPeaks(const cv::Mat1f& score, int reach_px) {
  cv::Mat1f left = score.clone();
  std::vector<Shift> peaks;
  for (int i = 0; i < kNumPeaks; ++i) {
    double highest = 0.0;
    cv::Point at;
    cv::minMaxLoc(left, nullptr, &highest, nullptr, &at);
    if (highest <= 0.0) break;
    peaks.push_back({Eigen::Vector2d(at.x - reach_px, at.y - reach_px), highest});
    cv::circle(left, at, kPeakRadiusPx, -1.0, cv::FILLED);
  }
  return peaks;
}

// Shifts of `seen` against `stored` up to `reach_px` with the largest correlations.
std::vector<Shift> SearchShifts(const cv::Mat2f& stored,
                                const cv::Mat2f& seen,
                                const cv::Mat1b& is_stored,
                                const cv::Mat1b& is_seen,
                                int reach_px) {
  const auto weight_of = [](const cv::Mat1b& mask) {
    cv::Mat1f weight;
    mask.convertTo(weight, CV_32F, 1.0 / 255.0);
    return weight;
  };
  const auto padded = [&](const cv::Mat& from) {
    cv::Mat to;
    cv::copyMakeBorder(from, to, reach_px, reach_px, reach_px, reach_px, cv::BORDER_CONSTANT, 0.0);
    return to;
  };
  const auto energy_of = [](const cv::Mat2f& pattern) {
    cv::Mat1f energy;
    cv::transform(pattern.mul(pattern), energy, cv::Matx12f(1.0f, 1.0f));
    return energy;
  };
  const cv::Mat1f energy = energy_of(stored);
  const cv::Mat1f product = Correlated(padded(seen), stored);
  const cv::Mat1f stored_energy = Correlated(padded(weight_of(is_seen)), energy);
  const cv::Mat1f seen_energy = Correlated(padded(energy_of(seen)), weight_of(is_stored));
  // Where the pictures hardly overlap, chance would win.
  const double least = 0.25 * cv::sum(energy)[0];
  cv::Mat1f score(product.size(), -1.0f);
  for (int row = 0; row < product.rows; ++row) {
    for (int col = 0; col < product.cols; ++col) {
      if (stored_energy(row, col) < least || seen_energy(row, col) < least * 0.1) continue;
      const Eigen::Vector2d share = Eigen::Vector2d(col - reach_px, row - reach_px) / reach_px;
      score(row, col) = product(row, col) /
                        std::sqrt(stored_energy(row, col) * seen_energy(row, col)) *
                        static_cast<float>(1.0 - kFarShiftLoss * share.squaredNorm());
    }
  }
  return HighestPeaks(score, reach_px);
}

// stored(x) = seen(back * (x + shift)), in pixels of the canvas.
Motion MotionOf(const cv::Mat1d& back, const Eigen::Vector2d& shift, double scale) {
  Motion motion;
  for (int row = 0; row < 2; ++row) {
    motion(row, 0) = back(row, 0);
    motion(row, 1) = back(row, 1);
    motion(row, 2) = (back(row, 0) * shift.x() + back(row, 1) * shift.y() + back(row, 2)) / scale;
  }
  return motion;
}

}  // namespace

Patterns PatternsOf(const StripCanvas& canvas, const ProjectedPhoto& photo, double pixel_m) {
  const double factor = std::max(1.0, std::round(pixel_m / canvas.grid.cell_size_m));
  const cv::Size size(std::max(1, static_cast<int>(canvas.picture.cols / factor)),
                      std::max(1, static_cast<int>(canvas.picture.rows / factor)));
  Patterns patterns;
  patterns.scale = static_cast<double>(size.width) / canvas.picture.cols;
  const int side_px = BoxSide(kPatternWindowM / (canvas.grid.cell_size_m / patterns.scale));
  patterns.is_stored = ReducedMask(canvas.is_shown, size);
  patterns.is_seen = ReducedMask(photo.is_shown, size);
  patterns.stored = PatternsIn(canvas.picture, patterns.is_stored, side_px);
  patterns.seen = PatternsIn(photo.picture, patterns.is_seen, side_px);
  return patterns;
}

MotionSearch::MotionSearch(const StripCanvas& canvas,
                           const ProjectedPhoto& photo,
                           const WatchOptions& options)
    : patterns_(PatternsOf(canvas, photo, kCoarsePixelM)) {
  const double pixel_m = canvas.grid.cell_size_m / patterns_.scale;
  reach_px_ = static_cast<int>(std::ceil(options.max_offset_m / pixel_m));
}

std::vector<ScoredMotion> MotionSearch::WithTurn(double turn_deg, double scale) const {
  const cv::Size size = patterns_.seen.size();
  const cv::Point2f middle(0.5f * static_cast<float>(size.width - 1),
                           0.5f * static_cast<float>(size.height - 1));
  // Of OpenCV: counter-clockwise as seen, from source to result.
  const cv::Mat1d turn = cv::getRotationMatrix2D(middle, turn_deg, scale);
  cv::Mat2f seen;
  cv::Mat1b is_seen;
  cv::warpAffine(patterns_.seen, seen, turn, size);
  cv::warpAffine(patterns_.is_seen, is_seen, turn, size, cv::INTER_NEAREST);
  cv::Mat1d back;
  cv::invertAffineTransform(turn, back);
  std::vector<ScoredMotion> motions;
  for (const Shift& found :
       SearchShifts(patterns_.stored, seen, patterns_.is_stored, is_seen, reach_px_)) {
    motions.push_back({MotionOf(back, found.shift, patterns_.scale), found.score});
  }
  return motions;
}

}  // namespace freelsd
