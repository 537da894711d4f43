#include <algorithm>

#include "engine/cover/crop_fields.h"
#include "engine/cover/kind/cue_groups.h"
#include "engine/cover/look_alikes.h"
#include "engine/cover/ruts.h"
#include "engine/cover/wheel_tracks.h"

namespace freelsd {
namespace {

// Sides of the squares over which places in ruts are counted, and sprayed ground is averaged.
constexpr double kRutsM = 25.0;
constexpr double kSprayedM = 9.0;
// Keeps the logarithm finite where there is no rut.
constexpr double kLeastDensity = 0.01;

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

}  // namespace

void VisitCropCues(const CueInput& input, const CoverOptions& options, const CueVisitor& visit) {
  const Grid& grid = input.map.grid;
  cv::Mat1f rows = RowStrengths(input.photo, options);
  rows += 1.0f;
  visit(Cue::kRowStrength, LogOf(MeanOnMap(rows, input.photo, grid), 1.0));
  rows.release();
  const cv::Mat1f density =
      KnownMean(RutPlaces(input.photo, grid, options), kRutsM / grid.cell_size_m);
  visit(Cue::kRutDensity, LogOf(density + kLeastDensity, kLeastDensity));
  const cv::Mat1b sprayed = SprayedGround(FindWheelTracks(input.photo, options), grid, options);
  cv::Mat1f share;
  WithRestOfField(sprayed, input.photo, grid, options).convertTo(share, CV_32F, 1.0 / 255.0);
  visit(Cue::kSprayed, KnownMean(share, kSprayedM / grid.cell_size_m));
}

}  // namespace freelsd
