// An adjusted block and an elevation map as records, and back, so that another processor can go on
// from them.
#pragma once

#include "engine/adjustment/adjustment.h"
#include "engine/terrain/terrain.h"
#include "tests/evaluation/stages/stage_record.h"

namespace freelsd {

// `frame_ids`: of the whole flight. Views are recorded by their index there.
StageRecords RecordsOf(const AdjustedBlock& block, const std::vector<std::string>& frame_ids);
AdjustedBlock BlockFrom(const StageRecords& records,
                        const Camera& camera,
                        const std::vector<std::string>& frame_ids);

StageRecords RecordsOf(const ElevationMap& map);
ElevationMap MapFrom(const StageRecords& records);

}  // namespace freelsd
