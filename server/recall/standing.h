// What checks on later maps make of a site's standing. Private to recall.
#pragma once

#include <string>

#include "server/recall/map_cache.h"
#include "server/recall/plan_check.h"
#include "storage/storage.h"

namespace freelsd {

// The standing with one more check of the plan. Of the maps on which the plan fails, the newest one
// supersedes the site. Of the maps on which it holds, the newest one confirms the site. Of the maps
// that doubt it, the newest one counts, unless a map supersedes the site or confirms it later. The
// order of the checks therefore does not matter.
// `is_later`: false if the map may be later or earlier. Such a map confirms nothing, and no later
// map settles its doubt, nor that of a map whose own time is not exact.
// `shown_id`: what supersedes, for people.
Standing With(Standing standing,
              const PlanCheck& check,
              const MapRow& map,
              const std::string& shown_id,
              bool is_later);
// Of a site that is doubted: since when, by which flight and why.
std::string DoubtSentence(const Standing& standing);

// Log lines, and plans that are not needed any more.
void ReportAll(MapCache& maps, const std::vector<SiteRow>& sites, const Standings& others);

}  // namespace freelsd
