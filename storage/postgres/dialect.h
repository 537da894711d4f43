// What the shared stores state in PostgreSQL's own words.
#pragma once

#include "storage/stores/stores.h"

namespace freelsd {

// `is_shared`: other processes use the database at the same time.
Dialect PostgresDialect(bool is_shared);
extern const TelemetryQueries kPostgresTelemetry;
extern const SqlMapStore::Queries kPostgresMaps;

}  // namespace freelsd
