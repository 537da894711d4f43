// Private to kind/. Cues by what they are measured on, and means that leave out unknown cells.
#pragma once

#include "engine/cover/kind/cues.h"

namespace freelsd {

// Mean log-odds of grass over the views of each cell; NaN where no view classified it.
cv::Mat1f VisitViewCues(const CueInput& input, const CueVisitor& visit);
void VisitPhotoCues(const CueInput& input, const CueVisitor& visit);
void VisitCropCues(const CueInput& input, const CoverOptions& options, const CueVisitor& visit);
void VisitHeightCues(const CueInput& input,
                     const cv::Mat1f& view_log_odds,
                     const CoverOptions& options,
                     const CueVisitor& visit);

// Mean over a square of that side, of the known values; NaN where less than a tenth is known.
cv::Mat1f KnownMean(const cv::Mat1f& values, double side_cells);
// NaN where the value is; no value counts as less than `least`.
cv::Mat1f LogOf(const cv::Mat1f& values, double least);
// The orthophoto's values as means over map cells; NaN where no part of the cell is seen.
cv::Mat1f MeanOnMap(const cv::Mat1f& values, const Orthophoto& photo, const Grid& grid);

}  // namespace freelsd
