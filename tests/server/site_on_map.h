// Stores sites with the map of their flight, as an evaluation does.
#pragma once

#include "api/stored/stored.h"
#include "storage/storage.h"

namespace freelsd {

// A map of the site's flight with these rasters, about the site's origin and photographed when the
// site says; not in force. No frame shows it.
FlightMapRow StageMapOf(Storage& storage, const SiteRow& site, const SiteMap& ground);
// The site with that map, staged. It takes the place of former maps of the flight that show the
// same ground, or on which the site lay, unless another site lies on them.
EvaluationRows RowsOnMap(Storage& storage, SiteRow site, const SiteMap& ground);
// In one commit, with the standings of other sites.
void PutOnMap(Storage& storage,
              const SiteRow& site,
              const SiteMap& ground,
              const Standings& others = {});
// A site of which nothing was reconstructed, so that its flight has no map there.
void PutWithoutMap(Storage& storage, const SiteRow& site);

}  // namespace freelsd
