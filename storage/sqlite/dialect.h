// What the shared stores state in SQLite's own words.
#pragma once

#include "storage/stores/stores.h"

namespace freelsd {

Dialect SqliteDialect();
extern const TelemetryQueries kSqliteTelemetry;
extern const SqlMapStore::Queries kSqliteMaps;

}  // namespace freelsd
