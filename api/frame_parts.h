// Reads the fields of a frame's meta that have the same form in the API's JSON and in stored JSON.
#pragma once

#include "api/json_reader.h"

namespace freelsd {

// q and -q are the same rotation. Stored metas are compared as text, so the sign must be unique.
Eigen::Quaterniond WithPositiveW(const Eigen::Quaterniond& q);
// Reads all fields except the attitude.
FrameMeta ReadCommonFrameFields(ObjectReader& reader);

}  // namespace freelsd
