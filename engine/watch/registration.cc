#include "engine/watch/registration.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"
#include "engine/watch/light_bands.h"

namespace freelsd {
namespace {

// Pixels of the search over the whole picture, and of the search block by block.
constexpr double kCoarsePixelM = 0.3;
constexpr double kBlockPixelM = 0.2;
// Surroundings against which brightness becomes pattern.
constexpr double kPatternWindowM = 3.0;
constexpr double kPatternSmoothingPx = 0.7;
constexpr double kTurnStepDeg = 1.5;
// How far blocks are searched after the coarse search, and after the first fit.
constexpr double kFirstReachM = 1.8;
constexpr double kSecondReachM = 0.7;
// Blocks overlap by half.
constexpr double kBlockStepRatio = 0.5;
constexpr double kLeastShownRatio = 0.7;
// A fit needs matches all around the strip.
constexpr int kMinNumFitted = 6;
// Of the coarse motions, the most similar one may be wrong.
constexpr size_t kMaxNumTrials = 6;

using Motion = Eigen::Matrix<double, 2, 3>;

Motion NoMotion() { return Motion::Identity(); }

Displacement DisplacementOf(const Motion& motion) {
  return [motion](double col, double row) -> Eigen::Vector2d {
    return motion * Eigen::Vector3d(col, row, 1.0) - Eigen::Vector2d(col, row);
  };
}

// Two pictures' patterns at a coarser pixel.
struct Patterns {
  cv::Mat1f stored, seen;
  cv::Mat1b is_stored, is_seen;
  // Of the canvas to these pixels.
  double scale = 1.0;
};

cv::Mat1f BrightnessOf(const cv::Mat3f& picture, const cv::Size& size) {
  cv::Mat3f reduced;
  cv::resize(picture, reduced, size, 0.0, 0.0, cv::INTER_AREA);
  // In the dark, the pattern of grass is hardly stronger than the noise of single pixels.
  cv::GaussianBlur(reduced, reduced, {}, kPatternSmoothingPx);
  return BandsOf(reduced, 1.0).brightness;
}

cv::Mat1b ReducedMask(const cv::Mat1b& mask, const cv::Size& size) {
  cv::Mat1b reduced;
  cv::resize(mask, reduced, size, 0.0, 0.0, cv::INTER_AREA);
  return reduced == 255;
}

Patterns PatternsOf(const StripCanvas& canvas, const ProjectedPhoto& photo, double pixel_m) {
  const double factor = std::max(1.0, std::round(pixel_m / canvas.grid.cell_size_m));
  const cv::Size size(std::max(1, static_cast<int>(canvas.picture.cols / factor)),
                      std::max(1, static_cast<int>(canvas.picture.rows / factor)));
  Patterns patterns;
  patterns.scale = static_cast<double>(size.width) / canvas.picture.cols;
  const int side_px = BoxSide(kPatternWindowM / (canvas.grid.cell_size_m / patterns.scale));
  patterns.is_stored = ReducedMask(canvas.is_shown, size);
  patterns.is_seen = ReducedMask(photo.is_shown, size);
  patterns.stored = PatternOf(BrightnessOf(canvas.picture, size), patterns.is_stored, side_px);
  patterns.seen = PatternOf(BrightnessOf(photo.picture, size), patterns.is_seen, side_px);
  return patterns;
}

struct BestShift {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double correlation = -1.0;
};

cv::Mat1f Correlated(const cv::Mat1f& image, const cv::Mat1f& pattern) {
  cv::Mat1f result;
  cv::matchTemplate(image, pattern, result, cv::TM_CCORR);
  return result;
}

// Shift of `seen` against `stored` up to `reach_px` with the largest correlation.
BestShift SearchShift(const cv::Mat1f& stored,
                      const cv::Mat1f& seen,
                      const cv::Mat1b& is_seen,
                      int reach_px) {
  cv::Mat1f padded, weight, stored_weight = cv::Mat1f(stored.size());
  cv::Mat1f seen_weight;
  is_seen.convertTo(seen_weight, CV_32F, 1.0 / 255.0);
  const auto pad = [&](const cv::Mat1f& from, cv::Mat1f& to) {
    cv::copyMakeBorder(from, to, reach_px, reach_px, reach_px, reach_px, cv::BORDER_CONSTANT, 0.0);
  };
  pad(seen, padded);
  pad(seen_weight, weight);
  cv::Mat1b(stored != 0.0f).convertTo(stored_weight, CV_32F, 1.0 / 255.0);
  const cv::Mat1f product = Correlated(padded, stored);
  const cv::Mat1f stored_energy = Correlated(weight, stored.mul(stored));
  const cv::Mat1f seen_energy = Correlated(padded.mul(padded), stored_weight);
  // Where the pictures hardly overlap, chance would win.
  const double least = 0.25 * cv::sum(stored.mul(stored))[0];
  BestShift best;
  for (int row = 0; row < product.rows; ++row) {
    for (int col = 0; col < product.cols; ++col) {
      if (stored_energy(row, col) < least || seen_energy(row, col) < least * 0.1) continue;
      const double correlation =
          product(row, col) / std::sqrt(double(stored_energy(row, col)) * seen_energy(row, col));
      if (correlation <= best.correlation) continue;
      best = {Eigen::Vector2d(col - reach_px, row - reach_px), correlation};
    }
  }
  return best;
}

// Turns about the middle of the picture and shifts, in pixels of the canvas; the most similar
// first.
std::vector<Motion> CoarseMotions(const StripCanvas& canvas,
                                  const ProjectedPhoto& photo,
                                  const WatchOptions& options) {
  const Patterns patterns = PatternsOf(canvas, photo, kCoarsePixelM);
  const double pixel_m = canvas.grid.cell_size_m / patterns.scale;
  const int reach_px = static_cast<int>(std::ceil(options.max_offset_m / pixel_m));
  const cv::Point2f middle(0.5f * static_cast<float>(patterns.seen.cols - 1),
                           0.5f * static_cast<float>(patterns.seen.rows - 1));
  const int num_turns = static_cast<int>(options.max_turn_deg / kTurnStepDeg);
  std::vector<std::pair<double, Motion>> candidates;
  for (int i = -num_turns; i <= num_turns; ++i) {
    // Of OpenCV: counter-clockwise as seen, from source to result.
    const cv::Mat1d turn = cv::getRotationMatrix2D(middle, i * kTurnStepDeg, 1.0);
    cv::Mat1f seen;
    cv::Mat1b is_seen;
    cv::warpAffine(patterns.seen, seen, turn, patterns.seen.size());
    cv::warpAffine(patterns.is_seen, is_seen, turn, patterns.seen.size(), cv::INTER_NEAREST);
    const BestShift found = SearchShift(patterns.stored, seen, is_seen, reach_px);
    Motion motion = NoMotion();
    cv::Mat1d back;
    cv::invertAffineTransform(turn, back);
    // stored(x) = seen(back * (x + shift)).
    for (int row = 0; row < 2; ++row) {
      motion(row, 0) = back(row, 0);
      motion(row, 1) = back(row, 1);
      motion(row, 2) =
          (back(row, 0) * found.shift.x() + back(row, 1) * found.shift.y() + back(row, 2)) /
          patterns.scale;
    }
    candidates.emplace_back(found.correlation, motion);
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.first > b.first;
  });
  std::vector<Motion> motions;
  motions.reserve(candidates.size());
  for (const auto& [correlation, motion] : candidates) motions.push_back(motion);
  return motions;
}

// A square of the stored picture and where the photograph shows it, pixels of the canvas.
struct Match {
  cv::Point2f stored;
  cv::Point2f offset;
  float correlation = 0.0f;
};

float PeakOffset(float before, float peak, float after) {
  const float bend = before - 2.0f * peak + after;
  return bend < 0.0f ? std::clamp(0.5f * (before - after) / bend, -0.5f, 0.5f) : 0.0f;
}

std::optional<Match> MatchBlock(const Patterns& patterns, const cv::Rect& block, int reach_px) {
  const cv::Rect search(block.x - reach_px,
                        block.y - reach_px,
                        block.width + 2 * reach_px,
                        block.height + 2 * reach_px);
  const cv::Rect all({}, patterns.stored.size());
  if ((search & all) != search) return std::nullopt;
  const double least = kLeastShownRatio * block.area();
  if (cv::countNonZero(patterns.is_stored(block)) < least ||
      cv::countNonZero(patterns.is_seen(search)) < kLeastShownRatio * search.area()) {
    return std::nullopt;
  }
  cv::Mat1f correlation;
  cv::matchTemplate(
      patterns.seen(search), patterns.stored(block), correlation, cv::TM_CCORR_NORMED);
  double peak = 0.0;
  cv::Point at;
  cv::minMaxLoc(correlation, nullptr, &peak, nullptr, &at);
  // At the border of the search there is no maximum.
  if (at.x == 0 || at.y == 0 || at.x == 2 * reach_px || at.y == 2 * reach_px) return std::nullopt;
  const auto value = [&](int dx, int dy) { return correlation(at.y + dy, at.x + dx); };
  Match match;
  const float scale = static_cast<float>(1.0 / patterns.scale);
  match.stored = {scale * static_cast<float>(block.x + 0.5 * block.width) - 0.5f,
                  scale * static_cast<float>(block.y + 0.5 * block.height) - 0.5f};
  match.offset = {scale * (static_cast<float>(at.x - reach_px) +
                           PeakOffset(value(-1, 0), value(0, 0), value(1, 0))),
                  scale * (static_cast<float>(at.y - reach_px) +
                           PeakOffset(value(0, -1), value(0, 0), value(0, 1)))};
  match.correlation = static_cast<float>(peak);
  return match;
}

struct Matches {
  std::vector<Match> good;
  int num_tried = 0;
};

Matches MatchBlocks(const Patterns& patterns,
                    const StripCanvas& canvas,
                    double reach_m,
                    const WatchOptions& options) {
  const double pixel_m = canvas.grid.cell_size_m / patterns.scale;
  const int side = std::max(8, static_cast<int>(std::lround(options.block_m / pixel_m)));
  const int step = std::max(1, static_cast<int>(side * kBlockStepRatio));
  const int reach_px = std::max(2, static_cast<int>(std::ceil(reach_m / pixel_m)));
  Matches matches;
  for (int row = 0; row + side <= patterns.stored.rows; row += step) {
    for (int col = 0; col + side <= patterns.stored.cols; col += step) {
      const cv::Rect block(col, row, side, side);
      const cv::Rect search(
          col - reach_px, row - reach_px, side + 2 * reach_px, side + 2 * reach_px);
      if ((search & cv::Rect({}, patterns.stored.size())) != search) continue;
      const double shown = kLeastShownRatio * side * side;
      if (cv::countNonZero(patterns.is_stored(block)) < shown ||
          cv::countNonZero(patterns.is_seen(block)) < shown) {
        continue;
      }
      ++matches.num_tried;
      const auto match = MatchBlock(patterns, block, reach_px);
      if (match && match->correlation >= options.min_match_correlation) {
        matches.good.push_back(*match);
      }
    }
  }
  return matches;
}

// Affine motion of the canvas that most matches agree with, and those matches. OpenCV draws the
// same numbers every time.
std::optional<Motion> Fit(std::vector<Match>& matches, double max_error_px) {
  if (static_cast<int>(matches.size()) < kMinNumFitted) return std::nullopt;
  std::vector<cv::Point2f> from, to;
  for (const Match& match : matches) {
    from.push_back(match.stored);
    to.push_back(match.stored + match.offset);
  }
  std::vector<uchar> agrees;
  constexpr size_t kNumTrials = 1000;
  const cv::Mat1d affine =
      cv::estimateAffine2D(from, to, agrees, cv::RANSAC, max_error_px, kNumTrials);
  if (affine.empty()) return std::nullopt;
  std::vector<Match> kept;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (agrees[i] != 0) kept.push_back(matches[i]);
  }
  matches = std::move(kept);
  Motion motion;
  for (int row = 0; row < 2; ++row) {
    for (int col = 0; col < 3; ++col) motion(row, col) = affine(row, col);
  }
  return motion;
}

Motion Joined(const Motion& outer, const Motion& inner) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Identity(), b = a;
  a.topRows<2>() = outer;
  b.topRows<2>() = inner;
  return (a * b).topRows<2>();
}

// Whether scale and turn are those of a pose error.
bool IsPlausible(const Motion& motion, const WatchOptions& options) {
  constexpr double kMaxStretch = 0.12;
  const Eigen::Matrix2d linear = motion.leftCols<2>();
  const Eigen::Vector2d stretch = linear.jacobiSvd().singularValues();
  const double turn = std::atan2(linear(1, 0) - linear(0, 1), linear(0, 0) + linear(1, 1));
  return std::abs(stretch[0] - 1.0) < kMaxStretch && std::abs(stretch[1] - 1.0) < kMaxStretch &&
         std::abs(DegFromRad(turn)) < 1.5 * options.max_turn_deg + 1.0;
}

// The common motion, and near each match what is left of its own.
Displacement Blended(const Motion& motion, const std::vector<Match>& matches, double radius_px) {
  const auto shared = std::make_shared<std::vector<Match>>(matches);
  return [motion, shared, radius_px](double col, double row) -> Eigen::Vector2d {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    // Far from all matches, the common motion holds.
    double weights = 0.2;
    for (const Match& match : *shared) {
      const double dx = col - match.stored.x, dy = row - match.stored.y;
      const double share = (dx * dx + dy * dy) / (radius_px * radius_px);
      if (share >= 4.0) continue;
      const double weight = match.correlation * std::exp(-2.0 * share);
      sum += weight * Eigen::Vector2d(match.offset.x, match.offset.y);
      weights += weight;
    }
    const Eigen::Vector2d there = Eigen::Vector2d(col, row) + sum / weights;
    return motion * there.homogeneous() - Eigen::Vector2d(col, row);
  };
}

// From a coarse motion to that of every square; nothing if too few squares agree.
std::optional<StripRegistration> Refined(const Motion& coarse,
                                         const WatchedPhoto& photo,
                                         const StripGround& ground,
                                         const StripCanvas& canvas,
                                         const WatchOptions& options) {
  const double pixel_m = canvas.grid.cell_size_m;
  Motion motion = coarse;
  Matches matches;
  // Two fits of the common motion; then what each square is left with.
  const std::vector<double> reaches_m{kFirstReachM, kSecondReachM, kSecondReachM};
  for (size_t i = 0; i < reaches_m.size(); ++i) {
    const ProjectedPhoto projected = Project(photo, ground, canvas, DisplacementOf(motion));
    matches =
        MatchBlocks(PatternsOf(canvas, projected, kBlockPixelM), canvas, reaches_m[i], options);
    const std::optional<Motion> rest = Fit(matches.good, options.max_match_error_m / pixel_m);
    if (!rest) return std::nullopt;
    if (i + 1 < reaches_m.size()) motion = Joined(motion, *rest);
  }
  const auto num_good = static_cast<int>(matches.good.size());
  if (num_good < options.min_num_matches ||
      num_good < options.min_match_ratio * matches.num_tried || !IsPlausible(motion, options)) {
    return std::nullopt;
  }
  StripRegistration registration;
  double sum = 0.0, squares = 0.0;
  for (const Match& match : matches.good) {
    sum += match.correlation;
    squares += match.offset.dot(match.offset);
  }
  registration.correlation = sum / num_good;
  registration.error_m = pixel_m * std::sqrt(squares / num_good);
  if (registration.error_m > options.max_registration_error_m) return std::nullopt;
  registration.displacement = Blended(motion, matches.good, options.block_m / pixel_m);
  return registration;
}

}  // namespace

std::optional<StripRegistration> Register(const WatchedPhoto& photo,
                                          const StripGround& ground,
                                          const StripCanvas& canvas,
                                          const WatchOptions& options) {
  const ProjectedPhoto projected = Project(photo, ground, canvas, DisplacementOf(NoMotion()));
  std::vector<Motion> motions = CoarseMotions(canvas, projected, options);
  motions.resize(std::min(motions.size(), kMaxNumTrials));
  for (const Motion& motion : motions) {
    auto registration = Refined(motion, photo, ground, canvas, options);
    if (registration) return registration;
  }
  return std::nullopt;
}

}  // namespace freelsd
