// Reading of a frame's meta: the parts that the API's JSON and the stored JSON have in common.
#pragma once

#include "api/json_reader.h"

namespace freelsd {

// q and -q are the same rotation. Stored metas are compared as text, so the sign must be unique.
Eigen::Quaterniond WithPositiveW(const Eigen::Quaterniond& q);
// Reads all fields except the attitude.
FrameMeta ReadCommonFrameFields(ObjectReader& reader);

}  // namespace freelsd
