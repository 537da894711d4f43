#include "storage/postgres/organisations/organisations.h"

#include "storage/storage.h"

namespace freelsd {

const char* const kAppRole = "freelsd_app";

std::string SettingOf(const std::string& organisation) {
  // The name goes into the text.
  if (!IsOrganisationName(organisation)) {
    throw StorageError("begin a transaction", "\"" + organisation + "\" is no organisation's name");
  }
  return "SELECT set_config('freelsd.organisation', '" + organisation + "', true)";
}

void ServeAllOrganisations(PostgresConnection& connection) {
  connection.Execute("SELECT set_config('freelsd.all_organisations', 'on', true)");
}

void RegisterOrganisation(PostgresConnection& writer, const std::string& name) {
  writer.Run("INSERT INTO organisations (name) VALUES ($1) ON CONFLICT DO NOTHING", name);
  writer.Run("INSERT INTO organisation_usage VALUES ($1, 0, 0, '-infinity') ON CONFLICT DO NOTHING",
             name);
}

bool FindsBoxesByIndex(PostgresConnection& connection) {
  constexpr char kIsMarked[] =
      "SELECT bool_and(proleakproof) FROM pg_proc JOIN pg_operator ON oprcode = pg_proc.oid "
      "WHERE oprname = '&&' AND oprleft = 'geometry'::regtype AND oprright = 'geometry'::regtype";
  return connection.Run(kIsMarked)[0].Bool(0);
}

bool MarkedBoxesFound(PostgresConnection& connection) {
  if (FindsBoxesByIndex(connection)) return true;
  try {
    connection.Execute("ALTER FUNCTION geometry_overlaps(geometry, geometry) LEAKPROOF");
  } catch (const ConnectionLost&) {
    throw;
  } catch (const StorageError&) {
    return false;
  }
  return true;
}

}  // namespace freelsd
