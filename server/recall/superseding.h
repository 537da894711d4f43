// Decides which stored sites later maps supersede. The plan of an accepted site, with its own
// aircraft and wind, is checked on the map of every site of another flight that was photographed
// later, in whatever order the flights arrived:
// - It fails on one: the site is superseded, for as long as that map is stored.
// - It holds on one: its ground was seen then too.
// Nothing else supersedes. The caller holds Service::sites_mutex.
#pragma once

#include <functional>
#include <string>

#include "server/recall/map_cache.h"
#include "storage/storage.h"

namespace freelsd {

// Stores a site with its map (empty: no map), its standing, and the standings of the sites that the
// map changes, in one commit.
void StoreSite(Storage& storage, MapCache& maps, SiteRow site, const std::string& map_blob);

// Deletes a site. Sites whose standing depended on its map are checked again on the others, in the
// same commit. False if there is no such site.
bool ForgetSite(Storage& storage, MapCache& maps, const std::string& site_id);

// Checks the site if an older program stored it and it was never checked.
void CheckUnchecked(Storage& storage, MapCache& maps, const std::string& site_id);

}  // namespace freelsd
