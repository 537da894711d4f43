#include <opencv2/imgproc.hpp>

#include "engine/cover/kind/cue_groups.h"
#include "engine/cover/overreach.h"
#include "engine/cover/photo_features.h"

namespace freelsd {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
// Side of the square that a cell's colour is compared with.
constexpr double kSurroundingsM = 61.0;
// Mean log-odds of the views from which a cell counts as grass, or, negative, as other ground,
// where colours are compared. 0.85 is a probability of 0.7 (ClassificationOptions).
constexpr float kToldLogOdds = 0.85f;

}  // namespace

void VisitColorCues(const CueInput& input,
                    const cv::Mat1f& view_log_odds,
                    const CoverOptions& options,
                    const CueVisitor& visit) {
  ColorsOnMap on_map = ColorsOfMap(input.photo, input.map.grid);
  const cv::Mat1f other = OtherGroundLogRatio(view_log_odds >= kToldLogOdds,
                                              view_log_odds <= -kToldLogOdds,
                                              on_map,
                                              input.map.grid,
                                              options);
  for (cv::Mat1f& plane : on_map.colors) plane.setTo(kUnknown, on_map.is_seen == 0);
  const double side = kSurroundingsM / input.map.grid.cell_size_m;
  visit(Cue::kGreenness, on_map.colors[0]);
  visit(Cue::kRedMinusBlue, on_map.colors[1]);
  visit(Cue::kGreennessContrast, on_map.colors[0] - KnownMean(on_map.colors[0], side));
  visit(Cue::kBrightnessContrast, on_map.colors[2] - KnownMean(on_map.colors[2], side));
  visit(Cue::kColorOfOther, other);
}

}  // namespace freelsd
