// SQL for rows of sites, and what recall reads.
#pragma once

#include "storage/stores/stores.h"

namespace freelsd {

extern const SiteQueries kPostgresSites;

}  // namespace freelsd
