// An adjusted block and an elevation map as records, and back, so that another processor can go on
// from them.
#pragma once

#include "engine/adjustment/adjustment.h"
#include "engine/terrain/terrain.h"
#include "tests/evaluation/stages/stage_record.h"

namespace freelsd {

StageRecords RecordsOf(const AdjustedBlock& block);
// `views`: the connected views are named like these frames, in the same order.
AdjustedBlock BlockFrom(const StageRecords& records,
                        const Camera& camera,
                        const std::vector<std::string>& frame_ids);

StageRecords RecordsOf(const ElevationMap& map);
ElevationMap MapFrom(const StageRecords& records);

}  // namespace freelsd
