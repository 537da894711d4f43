#include "engine/watch/registration.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"
#include "engine/watch/motion_search.h"

namespace freelsd {
namespace {

// Pixel of the search block by block.
constexpr double kBlockPixelM = 0.2;
constexpr double kTurnStepDeg = 1.5;
// How far blocks are searched after the coarse search, and after the first fit.
constexpr double kFirstReachM = 1.8;
constexpr double kSecondReachM = 0.7;
// Matches may lie so much farther from the motion before it is refined.
constexpr double kFirstErrorRatio = 1.7;
// Blocks overlap by half.
constexpr double kBlockStepRatio = 0.5;
constexpr double kLeastShownRatio = 0.7;
// A fit needs matches all around the strip.
constexpr int kMinNumFitted = 6;
// Of each turn, the most similar shift may be wrong. So many others are tried.
constexpr size_t kMaxNumOthers = 6;

Displacement DisplacementOf(const Motion& motion) {
  return [motion](double col, double row) -> Eigen::Vector2d {
    return motion * Eigen::Vector3d(col, row, 1.0) - Eigen::Vector2d(col, row);
  };
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
    const bool is_last = i + 1 == reaches_m.size();
    const double max_error_m = options.max_match_error_m * (is_last ? 1.0 : kFirstErrorRatio);
    const std::optional<Motion> rest = Fit(matches.good, max_error_m / pixel_m);
    if (!rest) return std::nullopt;
    if (!is_last) motion = Joined(motion, *rest);
  }
  const auto num_good = static_cast<int>(matches.good.size());
  if (num_good < options.min_num_matches ||
      num_good < options.min_match_ratio * matches.num_tried || !IsPlausible(motion, options)) {
    return std::nullopt;
  }
  StripRegistration registration;
  registration.num_matches = num_good;
  registration.num_tried = matches.num_tried;
  double sum = 0.0, squares = 0.0;
  for (const Match& match : matches.good) {
    sum += match.correlation;
    squares += match.offset.dot(match.offset);
  }
  registration.correlation = sum / num_good;
  registration.error_m = pixel_m * std::sqrt(squares / num_good);
  registration.displacement = Blended(motion, matches.good, options.block_m / pixel_m);
  return registration;
}

// Degrees and ratios, the most likely ones first: small ones.
std::vector<std::pair<double, double>> TurnsAndScales(const WatchOptions& options) {
  std::vector<std::pair<double, double>> pairs;
  for (const double scale :
       {1.0, 1.0 - options.max_scale_error_ratio, 1.0 + options.max_scale_error_ratio}) {
    pairs.emplace_back(0.0, scale);
    for (double turn = kTurnStepDeg; turn <= options.max_turn_deg; turn += kTurnStepDeg) {
      pairs.emplace_back(turn, scale);
      pairs.emplace_back(-turn, scale);
    }
  }
  return pairs;
}

}  // namespace

std::optional<StripRegistration> Register(const WatchedPhoto& photo,
                                          const StripGround& ground,
                                          const StripCanvas& canvas,
                                          const WatchOptions& options) {
  const ProjectedPhoto projected =
      Project(photo, ground, canvas, DisplacementOf(Motion::Identity()));
  const MotionSearch search(canvas, projected, options);
  std::vector<ScoredMotion> others;
  for (const auto& [turn_deg, scale] : TurnsAndScales(options)) {
    const std::vector<ScoredMotion> motions = search.WithTurn(turn_deg, scale);
    if (motions.empty()) continue;
    auto registration = Refined(motions.front().motion, photo, ground, canvas, options);
    if (registration) return registration;
    others.insert(others.end(), motions.begin() + 1, motions.end());
  }
  std::stable_sort(others.begin(), others.end(), [](const ScoredMotion& a, const ScoredMotion& b) {
    return a.score > b.score;
  });
  others.resize(std::min(others.size(), kMaxNumOthers));
  for (const ScoredMotion& other : others) {
    auto registration = Refined(other.motion, photo, ground, canvas, options);
    if (registration) return registration;
  }
  return std::nullopt;
}

}  // namespace freelsd
