// SQL for rows of sites and their standings.
#pragma once

#include <string>

#include "storage/box_cache.h"
#include "storage/postgres/connection.h"
#include "storage/site_store.h"

namespace freelsd {

// Writes are within the caller's transaction.
void PutSite(PostgresConnection& writer, const SiteRow& site);
// Ids without a site are ignored.
void PutSiteStandings(PostgresConnection& writer, const Standings& standings);

// Columns of a site without recall and map_box, and the row that they give.
extern const char* const kSiteColumns;
SiteRow SiteRowOf(const PostgresRow& row);
// Of both lists of columns.
extern const char* const kRecallColumns;
SiteRow WholeSiteRowOf(const PostgresRow& row);

// The box must not cross the antimeridian.
BoxCache<RecallRow>::Rows SelectRecallRows(PostgresConnection& connection, const BoundingBox& box);
// Of sites that a later map has superseded.
BoxCache<std::string>::Rows SelectOverruledIds(PostgresConnection& connection,
                                               const BoundingBox& box);
BoxCache<MapRow>::Rows SelectMapRows(PostgresConnection& connection, const BoundingBox& box);

}  // namespace freelsd
