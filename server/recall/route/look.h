// Ground below a gap of a route that is worth a look. Private to recall.
#pragma once

#include <optional>

#include "server/recall/route/fixes.h"

namespace freelsd {

// The ground below the gap that nobody has seen, and from which a strip would close most of the
// gap. The strip is assumed as high as the highest stored site nearby, and to be landed on in the
// worst of its directions. Terrain and obstacles on the way there are unknown. Nothing if no site
// is stored nearby, if all the ground was seen, or if a strip helps less than half of the gap.
std::optional<RouteFix> LookFirst(const RouteJudge& judge,
                                  const StoredSites& stored,
                                  const RouteRequest& request,
                                  const Insurance& insurance,
                                  size_t gap);

}  // namespace freelsd
