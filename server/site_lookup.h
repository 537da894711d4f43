// The site that a path names.
#pragma once

#include "server/call.h"
#include "server/replan.h"
#include "server/service.h"

namespace freelsd {

// Throws ApiError NoSuchSite.
SiteRow ExistingSite(const Service& service, const Call& call);

}  // namespace freelsd
