// Creates the schema in a PostgreSQL database.
#pragma once

#include "storage/postgres/connection.h"

namespace freelsd {

// In an empty database, in one transaction. One process at a time does so; others wait. Throws
// StorageError, and changes nothing, if the schema has another number: kNewer, if a newer program
// wrote it.
void CreateSchema(PostgresConnection& connection);

}  // namespace freelsd
