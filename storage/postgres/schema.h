// Creates the schema in a PostgreSQL database.
#pragma once

#include "storage/postgres/connection.h"

namespace freelsd {

// Creates the schema, in one transaction, unless it is there. One process at a time does so; others
// wait. Throws StorageError kOtherSchema, and changes nothing, if the schema there has another
// number.
void CreateSchema(PostgresConnection& connection);

}  // namespace freelsd
