#include "server/intake/quota.h"

#include <cmath>

#include "api/api.h"

namespace freelsd {
namespace {

ApiError ErrorOf(const QuotaRefusal& refusal) {
  switch (refusal.quota) {
    case Quota::kImageBytes:
      return {"ByteQuota", "the images of the organisation would exceed its quota of bytes"};
    case Quota::kJobs:
      return {"JobQuota", "the organisation has as many unfinished jobs as it may have"};
    case Quota::kFrames:
      break;
  }
  const auto wait_s = static_cast<int64_t>(std::ceil(refusal.wait_s));
  return {"FrameQuota",
          "the organisation sends more frames than it may in a minute; there is room again in " +
              std::to_string(wait_s) + " s"};
}

}  // namespace

void RefuseOverQuota(Intake& intake, const QuotaDemand& demand) {
  const std::optional<QuotaRefusal> refusal = intake.storage.quotas.Admit(intake.quotas, demand);
  if (!refusal) return;
  ApiError error = ErrorOf(*refusal);
  error.limit = refusal->limit;
  error.observed = refusal->observed;
  throw error;
}

}  // namespace freelsd
