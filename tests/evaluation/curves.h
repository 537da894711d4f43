// The paper's figures as pictures: ROC and precision over recall, regions over the frames, approach
// profiles.
#pragma once

#include <string>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/statistics.h"

namespace freelsd {

// Writes DIR/NAME-roc.png: rate of grass found over rate of other ground taken for grass (green),
// precision over recall (blue); both axes 0 to 1.
void DrawRoc(const std::string& folder, const std::string& name, const RocCounts& counts);

// Writes DIR/NAME-regions.png, over the frames: observations, share of grass, area and grade, one
// below the other, a colour per graded region; DIR/NAME-profile-REGION.png for each site with an
// approach: ground (green) and path (blue) over the distance to touchdown.
void DrawCurves(const std::string& folder, const std::string& name, const EngineRun& run);

}  // namespace freelsd
