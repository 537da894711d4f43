#include "engine/cover/kind/cues.h"

#include <limits>

#include <opencv2/imgproc.hpp>

#include "engine/cover/kind/cue_groups.h"
#include "engine/cover/photo_bands.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
// Least known share of a square whose mean is known.
constexpr float kMinKnownShare = 0.1f;

}  // namespace

const std::array<const char*, kNumCues> kCueNames{"view_log_odds",
                                                  "view_log_odds_near",
                                                  "greenness_contrast",
                                                  "detail",
                                                  "tuft_texture",
                                                  "green_texture",
                                                  "shadow",
                                                  "row_strength",
                                                  "rut_density",
                                                  "sprayed",
                                                  "cover_height",
                                                  "roughness",
                                                  "height_deviation",
                                                  "unevenness",
                                                  "raised_border"};

cv::Mat1f KnownMean(const cv::Mat1f& values, double side_cells) {
  const cv::Mat1b is_known = cv::Mat1b(values == values);
  cv::Mat1f known, filled = values.clone();
  is_known.convertTo(known, CV_32F, 1.0 / 255.0);
  filled.setTo(0.0f, ~is_known);
  const int side = BoxSide(side_cells);
  const cv::Mat1f share = BoxMean(known, side, BoxBorder::kNothing);
  cv::Mat1f mean = BoxMean(filled, side, BoxBorder::kNothing) / share;
  mean.setTo(kUnknown, share < kMinKnownShare);
  return mean;
}

cv::Mat1f LogOf(const cv::Mat1f& values, double least) {
  cv::Mat1f logarithm;
  cv::log(cv::max(values, least), logarithm);
  logarithm.setTo(kUnknown, ~cv::Mat1b(values == values));
  return logarithm;
}

cv::Mat1f MeanOnMap(const cv::Mat1f& values, const Orthophoto& photo, const Grid& grid) {
  cv::Mat1f mean(grid.num_rows, grid.num_cols);
  for (const auto& [map_rows, photo_rows] : MapBandsOf(photo, grid)) {
    const cv::Size size(grid.num_cols, map_rows.size());
    cv::Mat1f seen, share, filled = values.rowRange(photo_rows).clone(), band;
    filled.setTo(0.0f, photo.seen.rowRange(photo_rows) == 0);
    photo.seen.rowRange(photo_rows).convertTo(seen, CV_32F, 1.0 / 255.0);
    cv::resize(seen, share, size, 0.0, 0.0, cv::INTER_AREA);
    cv::resize(filled, band, size, 0.0, 0.0, cv::INTER_AREA);
    band = band / share;
    band.setTo(kUnknown, share <= 0.0f);
    band.copyTo(mean.rowRange(map_rows));
  }
  return mean;
}

void VisitCues(const CueInput& input, const CoverOptions& options, const CueVisitor& visit) {
  const cv::Mat1f view_log_odds = VisitViewCues(input, visit);
  VisitHeightCues(input, view_log_odds, options, visit);
  if (input.photo.image.empty()) return;
  VisitPhotoCues(input, visit);
  VisitCropCues(input, options, visit);
}

}  // namespace freelsd
