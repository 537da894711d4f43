#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "engine/cover/crop_fields.h"
#include "engine/cover/fences.h"
#include "engine/cover/kind/cue_groups.h"
#include "engine/cover/look_alikes.h"
#include "engine/cover/raised_fields.h"
#include "engine/cover/ruts.h"
#include "engine/cover/small_objects.h"
#include "engine/cover/wheel_tracks.h"

namespace freelsd {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
// Side of the square over which places in ruts are counted, and sprayed ground is averaged.
constexpr double kRutsM = 25.0;
constexpr double kSprayedM = 9.0;
constexpr double kFenceM = 3.0;
constexpr double kDisagreementM = 9.0;
// Keeps the logarithm of two equal photographs finite.
constexpr float kLeastDisagreement = 0.005f;

cv::Mat1f ShareOf(const cv::Mat1b& mask, double side_cells) {
  cv::Mat1f share;
  mask.convertTo(share, CV_32F, 1.0 / 255.0);
  return KnownMean(share, side_cells);
}

// Places in ruts per cell.
cv::Mat1f RutPlaces(const Orthophoto& photo, const Grid& grid, const CoverOptions& options) {
  cv::Mat1f places = cv::Mat1f::zeros(grid.num_rows, grid.num_cols);
  const double ratio = photo.grid.cell_size_m / grid.cell_size_m;
  for (const TrackPlace& found : RutPairs(photo, options)) {
    const int row = std::clamp(static_cast<int>(found.place.y() * ratio), 0, grid.num_rows - 1);
    const int col = std::clamp(static_cast<int>(found.place.x() * ratio), 0, grid.num_cols - 1);
    places(row, col) += 1.0f;
  }
  return places;
}

// Grass by the views, on ground that is even.
cv::Mat1b EvenGrass(const CueInput& input,
                    const cv::Mat1f& view_log_odds,
                    const CoverOptions& options) {
  cv::Mat1b is_even(view_log_odds.size(), uint8_t{0});
  const double max_slope = RadFromDeg(options.max_even_slope_deg);
  for (int row = 0; row < is_even.rows; ++row) {
    for (int col = 0; col < is_even.cols; ++col) {
      if (view_log_odds(row, col) > 0.0f && input.surface.slope(row, col) <= max_slope &&
          input.surface.roughness(row, col) <= options.max_even_roughness_m) {
        is_even(row, col) = 255;
      }
    }
  }
  return is_even;
}

cv::Mat1f LogOf(const cv::Mat1f& values, float least) {
  cv::Mat1f logarithm;
  cv::log(values + least, logarithm);
  return logarithm;
}

void VisitCropCues(const CueInput& input, const CoverOptions& options, const CueVisitor& visit) {
  const Grid& grid = input.map.grid;
  visit(Cue::kRowStrength,
        LogOf(MeanOnMap(RowStrengths(input.photo, options), input.photo, grid), 1.0f));
  visit(Cue::kRutDensity,
        LogOf(KnownMean(RutPlaces(input.photo, grid, options), kRutsM / grid.cell_size_m), 0.01f));
  const cv::Mat1b sprayed = SprayedGround(FindWheelTracks(input.photo, options), grid, options);
  visit(
      Cue::kSprayed,
      ShareOf(WithRestOfField(sprayed, input.photo, grid, options), kSprayedM / grid.cell_size_m));
}

}  // namespace

void VisitDetectorCues(const CueInput& input,
                       const cv::Mat1f& view_log_odds,
                       const CoverOptions& options,
                       const CueVisitor& visit) {
  const double cell = input.map.grid.cell_size_m;
  visit(Cue::kObjectDeviation,
        LogOf(MostOnMap(ObjectDeviations(input.photo, options), input.map.grid), 0.1f));
  VisitCropCues(input, options, visit);
  const cv::Mat1b is_even = EvenGrass(input, view_log_odds, options);
  visit(Cue::kFence,
        ShareOf(FindFences(input.photo, is_even, input.map.grid, options), kFenceM / cell));
  visit(Cue::kRaisedBorder, RaisedBorderRatio(is_even, input.surface.elevation, cell, options));
  if (input.disagreement.empty()) return;
  visit(Cue::kDisagreement, LogOf(input.disagreement, kLeastDisagreement));
  visit(Cue::kDisagreementFar,
        LogOf(KnownMean(input.disagreement, kDisagreementM / cell), kLeastDisagreement));
}

}  // namespace freelsd
