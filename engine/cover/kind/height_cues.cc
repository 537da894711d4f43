#include "engine/cover/kind/cue_groups.h"
#include "engine/cover/kind/raised_border.h"

namespace freelsd {
namespace {

// No height is known better.
constexpr double kLeastDeviationM = 0.01;
// Side of the square around a cell.
constexpr double kNeighbourhoodM = 5.0;

// Deviation of the elevation from its mean over a square, without the part that slopes have.
cv::Mat1f Unevenness(const cv::Mat1f& elevation, double side_cells) {
  const cv::Mat1f rest = elevation - KnownMean(elevation, side_cells);
  cv::Mat1f deviation;
  cv::sqrt(KnownMean(rest.mul(rest), side_cells), deviation);
  return deviation;
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

}  // namespace

void VisitHeightCues(const CueInput& input,
                     const cv::Mat1f& view_log_odds,
                     const CoverOptions& options,
                     const CueVisitor& visit) {
  const cv::Mat1f& elevation = input.surface.elevation;
  const double cell = input.map.grid.cell_size_m;
  visit(Cue::kCoverHeight,
        KnownMean(input.map.upper - input.map.elevation, kNeighbourhoodM / cell));
  visit(Cue::kRoughness, LogOf(input.surface.roughness, kLeastDeviationM));
  visit(Cue::kHeightDeviation, LogOf(input.map.standard_deviation, kLeastDeviationM));
  visit(Cue::kUnevenness, LogOf(Unevenness(elevation, kNeighbourhoodM / cell), kLeastDeviationM));
  visit(Cue::kRaisedBorder,
        RaisedBorderRatio(EvenGrass(input, view_log_odds, options), elevation, cell));
}

}  // namespace freelsd
