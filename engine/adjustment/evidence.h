// Chooses the parameters of the motion during readout that the photographs justify.
#pragma once

#include <vector>

#include "engine/adjustment/solver.h"

namespace freelsd {

struct ChosenBlock {
  SolvedBlock solved;
  SolverSettings settings;
  // With the points of `solved`.
  std::vector<BlockTrack> tracks;
  std::vector<ParameterEvidence> evidence;
};

// The settings with which a block is solved before the choice: a uniform turn where nobody stated
// the readout time; where it is stated, also its change.
SolverSettings WithFirstTurns(SolverSettings settings,
                              const Camera& camera,
                              const AdjustmentOptions& options);

// The same state; the motion that `settings` does not estimate is zero.
BlockState Restricted(BlockState state, const SolverSettings& settings);

// Solves again without, or with more, powers of the turn, and keeps what Schwarz's criterion
// justifies. `start` was solved with WithFirstTurns.
ChosenBlock ChooseReadout(const std::vector<View>& views,
                          const Camera& camera,
                          const AdjustmentOptions& options,
                          ChosenBlock start);

}  // namespace freelsd
