// What a transaction says of whose rows it is about (schema.sql).
#pragma once

#include <string>

#include "storage/postgres/connection.h"

namespace freelsd {

// What all connections act as, once the schema is there.
extern const char* const kAppRole;

// A statement: its transaction sees and writes rows of this organisation, and reads what others
// share.
std::string SettingOf(const std::string& organisation);
// From now on, the transaction also sees which flights of any organisation have work, claims and
// events, and may change the last two.
void ServeAllOrganisations(PostgresConnection& connection);

// Within the organisation's transaction.
void RegisterOrganisation(PostgresConnection& writer, const std::string& name);

// Row-level security keeps a condition from an index unless its function is marked LEAKPROOF, which
// PostGIS leaves to the operator; only a superuser may. False if the boxes of geometries are not
// found by index.
bool FindsBoxesByIndex(PostgresConnection& connection);
// Marks it where it can. Outside of a transaction.
bool MarkedBoxesFound(PostgresConnection& connection);

}  // namespace freelsd
