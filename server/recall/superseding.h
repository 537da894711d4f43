// Decides which stored sites later maps supersede. The plan of an accepted site is checked on each
// map of another flight whose ground was photographed later. The check uses the site's own aircraft
// and wind. The order in which the flights arrived does not matter. Result:
// - The plan fails on one of the maps: the site is superseded while that map is stored.
// - The plan holds on one of the maps: the site counts as last seen when that map was photographed.
// Nothing else supersedes. The caller holds Service::sites_mutex.
#pragma once

#include <functional>
#include <string>

#include "server/recall/map_cache.h"
#include "storage/storage.h"

namespace freelsd {

// Stores a site with its map and its standing. An empty map_blob means no map. The standings of
// other sites that the map changes are stored in the same commit.
void StoreSite(Storage& storage, MapCache& maps, SiteRow site, const std::string& map_blob);

// Deletes a site. The standings that depended on its map are computed again from the remaining
// maps, and are stored in the same commit. False if there is no such site.
bool ForgetSite(Storage& storage, MapCache& maps, const std::string& site_id);

// Checks the site if it was never checked, because an older program stored it.
void CheckUnchecked(Storage& storage, MapCache& maps, const std::string& site_id);

}  // namespace freelsd
