// Merges what another server tells into what is stored. Of two versions of a site or an obstacle
// the later one counts (updated_at_us; ties: when its ground was last seen, then evidence_digest,
// then the bytes), and a removal removes the versions up to the one that it removed. Standings are
// what all stored maps say. So the result does not depend on the order in which changes arrive.
#pragma once

#include <string>
#include <vector>

#include "server/following/told_change.h"
#include "server/recall/recall.h"
#include "storage/storage.h"

namespace freelsd {

struct MergeResult {
  int64_t num_taken = 0;
  // Sites that may have changed.
  std::vector<SiteRow> sites;
};

// What a follower sends. Maps were staged before; throws ApiError MapMissing, and changes nothing,
// if one is not here. Where the outcome differs from what was told, the change is repeated in the
// feed, so that the follower gets it. Standings are computed here.
MergeResult MergeFromBelow(Storage& storage,
                           MapCache& maps,
                           const std::vector<ToldChange>& changes);

// Ids of the maps that must be staged before MergeFromAbove.
std::vector<std::string> MapsToFetch(const Storage& storage,
                                     const std::vector<ToldChange>& changes);
// What the followed server tells. Its standings count, and worse ones by maps that it does not know
// yet. A site whose map is not here is left out.
MergeResult MergeFromAbove(Storage& storage,
                           MapCache& maps,
                           const std::vector<ToldChange>& changes);

// Removes what was told once by the followed server but is not in its feed any more. `told`: all
// that is.
void RemoveUntold(Storage& storage,
                  MapCache& maps,
                  const std::vector<ChangeKey>& told,
                  const BoundingBox& area);

}  // namespace freelsd
