// Moved rows of tables that the stores write themselves, because other rows or checksums belong to
// them.
#pragma once

#include "storage/map_store.h"
#include "storage/move/rows.h"
#include "storage/obstacle_store.h"
#include "storage/site_store.h"

namespace freelsd {

SiteRow SiteIn(const MovedRow& row);
FlightMapRow MapIn(const MovedRow& row);
ObstacleRow ObstacleIn(const MovedRow& row);

}  // namespace freelsd
