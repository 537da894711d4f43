// Which views of a solved block are trusted, and how accurate they are.
#pragma once

#include <string>
#include <vector>

#include "engine/adjustment/landmarks.h"

namespace freelsd {

struct BlockVerdict {
  std::vector<bool> is_connected;
  // As AdjustedView::group.
  std::vector<int> group;
  // Per view, as AdjustedView::position_sd_m.
  std::vector<double> position_sd_m;
  // As AdjustedBlock::tilt_sd_deg; of the worst group of connected views.
  double tilt_sd_deg = 0.0;
  // Why groups of views were rejected; empty if none was.
  std::string note;
};

// Judges each connected group by itself, because its own priors place it.
BlockVerdict JudgeBlock(const std::vector<View>& views,
                        const BlockState& state,
                        const std::vector<BlockTrack>& tracks,
                        const AdjustmentOptions& options);

}  // namespace freelsd
