// Creates the schema in a PostgreSQL database, and migrates an older one.
#pragma once

#include "storage/postgres/connection.h"

namespace freelsd {

// Applies the migrations that the schema lacks, all in one transaction. One process at a time does
// so; others wait. Throws StorageError kNewer, and changes nothing, if a newer program wrote the
// schema.
void MigrateDatabase(PostgresConnection& connection);

}  // namespace freelsd
