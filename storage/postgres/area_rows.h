// Areas of sites and maps: boxes that do not cross the antimeridian, found by geometry.
#pragma once

#include <string>

#include "storage/postgres/connection.h"
#include "storage/site_store.h"

namespace freelsd {

// `table` is "site" or "map". Writes the parts of the box for the one with that id.
void PutArea(PostgresConnection& writer,
             const std::string& table,
             const std::string& id,
             const BoundingBox& box);
// Runs `select`, which ends with "id IN", on the ids of all whose area may meet the box. Areas are
// compared in single precision, rounded outwards.
PostgresRows SelectMeeting(PostgresConnection& connection,
                           const std::string& select,
                           const std::string& table,
                           const BoundingBox& box);

}  // namespace freelsd
