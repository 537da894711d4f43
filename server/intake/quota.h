// Refuses what would exceed the quotas of the organisation.
#pragma once

#include "server/intake/state.h"

namespace freelsd {

// Call it before anything of the request is stored. Throws ApiError FrameQuota, JobQuota or
// ByteQuota, with the limit and what there would be.
void RefuseOverQuota(Intake& intake, const QuotaDemand& demand);

}  // namespace freelsd
