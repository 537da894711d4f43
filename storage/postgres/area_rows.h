// Areas of sites and maps: boxes that do not cross the antimeridian, found by geometry.
#pragma once

#include <string>

#include "storage/postgres/connection.h"
#include "storage/site_store.h"

namespace freelsd {

// Writes the parts of the box for the site or map.
void PutSiteArea(PostgresConnection& writer, const std::string& site_id, const BoundingBox& box);
void PutMapArea(PostgresConnection& writer, const std::string& map_id, const BoundingBox& box);

// Runs `select`, which ends with "id IN", on the ids of all whose area may meet the box. Areas are
// compared in single precision, rounded outwards.
PostgresRows SelectSitesMeeting(PostgresConnection& connection,
                                const std::string& select,
                                const BoundingBox& box);
PostgresRows SelectMapsMeeting(PostgresConnection& connection,
                               const std::string& select,
                               const BoundingBox& box);

}  // namespace freelsd
