#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "engine/cover/kind/cue_groups.h"

namespace freelsd {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
// No height is known better.
constexpr float kLeastDeviationM = 0.01f;
// Sides of squares: what stands out of its surroundings, and what lies higher as a whole.
constexpr double kNearM = 5.0;
constexpr double kBumpM = 9.0;
constexpr double kRiseM = 31.0;

cv::Mat1f LogOf(const cv::Mat1f& values) {
  cv::Mat1f logarithm;
  cv::log(cv::max(values, kLeastDeviationM), logarithm);
  logarithm.setTo(kUnknown, ~cv::Mat1b(values == values));
  return logarithm;
}

// Height of each cell above the opening of the surface: what is narrower than the square.
cv::Mat1f Bumps(const cv::Mat1f& elevation, double side_cells) {
  const cv::Mat1b is_known = cv::Mat1b(elevation == elevation);
  const int side = 2 * static_cast<int>(0.5 * side_cells) + 1;
  const cv::Mat square = cv::Mat1b::ones(side, side);
  cv::Mat1f filled = elevation.clone(), low, opened;
  filled.setTo(std::numeric_limits<float>::max(), ~is_known);
  cv::erode(filled, low, square);
  low.setTo(std::numeric_limits<float>::lowest(), low == std::numeric_limits<float>::max());
  cv::dilate(low, opened, square);
  cv::Mat1f bumps = elevation - opened;
  bumps.setTo(kUnknown, ~is_known);
  return bumps;
}

// Deviation of the elevation from its mean over a square, without the part that slopes have.
cv::Mat1f Unevenness(const cv::Mat1f& elevation, double side_cells) {
  const cv::Mat1f rest = elevation - KnownMean(elevation, side_cells);
  cv::Mat1f deviation;
  cv::sqrt(KnownMean(rest.mul(rest), side_cells), deviation);
  return deviation;
}

}  // namespace

void VisitHeightCues(const CueInput& input, const CueVisitor& visit) {
  const cv::Mat1f& elevation = input.surface.elevation;
  const double cell = input.map.grid.cell_size_m;
  const cv::Mat1f height = input.map.upper - input.map.elevation;
  visit(Cue::kCoverHeight, height);
  visit(Cue::kCoverHeightNear, KnownMean(height, kNearM / cell));
  visit(Cue::kRoughness, LogOf(input.surface.roughness));
  visit(Cue::kSlope, input.surface.slope);
  visit(Cue::kHeightDeviation, LogOf(input.map.standard_deviation));
  visit(Cue::kBump, Bumps(elevation, kBumpM / cell));
  visit(Cue::kRise, KnownMean(elevation, kNearM / cell) - KnownMean(elevation, kRiseM / cell));
  visit(Cue::kUnevenness, LogOf(Unevenness(elevation, kNearM / cell)));
}

}  // namespace freelsd
