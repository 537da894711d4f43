// Decides which stored sites later maps supersede. The plan of an accepted site is checked on each
// map of another flight whose ground was photographed later. The check uses the site's own aircraft
// and wind. The order in which the flights arrived does not matter. Result:
// - The plan fails on one of the maps: the site is superseded while that map is stored.
// - The plan holds on one of the maps: the site counts as last seen when that map was photographed.
// Nothing else supersedes. Each change has the turn to change sites (SiteTurn) from its first check
// to its commit: two changes at the same time would each miss the other's map.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "server/recall/map_cache.h"
#include "storage/storage.h"

namespace freelsd {

// Stores the result of an evaluation in one commit: its sites with their standings, its staged
// maps, what they replace, and the standings of other flights' sites that change. The caller has
// had the turn since it read what `rows` are made from.
void StoreEvaluation(Storage& storage, MapCache& maps, SiteTurn& turn, EvaluationRows rows);

// What the server that this one follows does not know: maps and sites that are stored here.
struct UnknownAbove {
  std::vector<FlightMapRow> maps;
  std::set<std::string> sites;
};
// Stores what the followed server told, in one commit: sites with their told standings, staged
// maps, what is forgotten, and told standings of sites that are stored already. What that server
// does not know counts too: its maps for the told sites, and the told maps for its sites.
void StoreFollowed(Storage& storage,
                   MapCache& maps,
                   SiteTurn& turn,
                   EvaluationRows rows,
                   const Standings& told,
                   const UnknownAbove& unknown);

// Deletes a site; its flight's map stays. The standings that name it are computed again and stored
// in the same commit. False if there is no such site.
bool ForgetSite(Storage& storage, MapCache& maps, const std::string& site_id);

// Deletes the flight with its maps and sites, which may have outlived it. The standings that
// depended on them are computed again. All of it is one commit. False if there is none of them.
bool ForgetFlight(Storage& storage, MapCache& maps, const std::string& flight_id);

}  // namespace freelsd
