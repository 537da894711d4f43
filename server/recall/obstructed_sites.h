// Stored sites as obstacles leave them: a site whose stored plan meets an obstacle is no landing
// site for as long as the obstacle is there. Nothing of it is stored, so that the site is back by
// itself.
#pragma once

#include <optional>

#include "server/recall/obstruction.h"
#include "server/recall/recall_sites.h"

namespace freelsd {

// Nothing if the site was rejected anyway, or if its plan holds. Cached.
std::optional<Obstruction> ObstructionOf(const StoredSites& stored, const SiteRow& site);
// The row, its feature rejected if its plan meets an obstacle: verdict, reject_reason,
// reject_detail, blocked_by, summary.
SiteRow AsObstructed(const StoredSites& stored, SiteRow site);

}  // namespace freelsd
