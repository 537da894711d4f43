// Decides which views of a solved block are trusted, and estimates their accuracy.
#pragma once

#include <string>
#include <vector>

#include "engine/adjustment/landmarks.h"

namespace freelsd {

struct BlockVerdict {
  std::vector<bool> is_connected;
  // Per view, as AdjustedView::group.
  std::vector<int> group;
  // Per view, as AdjustedView::position_sd_m.
  std::vector<double> position_sd_m;
  // As AdjustedBlock::tilt_sd_deg: the largest value of all groups of connected views.
  double tilt_sd_deg = 0.0;
  // Reason why a group of views was rejected. If several groups were rejected, the reason for the
  // last one. Empty if no group was rejected. A group that is too small is rejected without a note.
  std::string note;
};

// Judges each connected group separately, because each group is positioned by its own priors.
BlockVerdict JudgeBlock(const std::vector<View>& views,
                        const BlockState& state,
                        const std::vector<BlockTrack>& tracks,
                        const AdjustmentOptions& options);

}  // namespace freelsd
