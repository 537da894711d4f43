#include "storage/sqlite/dialect.h"

namespace freelsd {
namespace {

std::map<std::string, int64_t> ExistingFlights(Database& writer,
                                               const std::vector<std::string>& flight_ids) {
  std::map<std::string, int64_t> next_us;
  for (const std::string& id : flight_ids) {
    if (!next_us.contains(id) && LockFlight(writer, id)) next_us[id] = NextArrival(writer, id);
  }
  return next_us;
}

void PutSamples(Database& writer, const std::vector<Sample>& samples) {
  for (const auto& [flight_id, row] : samples) {
    writer.Change("INSERT OR REPLACE INTO telemetry VALUES ($1, $2, $3, $4, $5, $6, $7, $8)",
                  flight_id,
                  static_cast<int>(row.kind),
                  row.timestamp_us,
                  row.values[0],
                  row.values[1],
                  row.values[2],
                  row.values[3],
                  row.arrived_at_us);
  }
}

}  // namespace

const TelemetryQueries kSqliteTelemetry{ExistingFlights, PutSamples};
const SqlMapStore::Queries kSqliteMaps{[](Database&, const FlightMapRow&) {},
                                       [](Database&, const PhotoTiles&) {}};

Dialect SqliteDialect() {
  Dialect dialect;
  // Rises with each row; that of the newest row is given again after it is deleted.
  dialect.flight_number = "rowid";
  dialect.flight_in_use =
      "SELECT 1 FROM frames WHERE flight_id = $1 AND state = 0 "
      "UNION ALL SELECT 1 FROM jobs WHERE flight_id = $1 AND state < 2";
  dialect.frame_image = "sha256";
  // Those that only frames of this flight name.
  dialect.retired_images =
      "SELECT DISTINCT sha256 FROM frames AS mine WHERE flight_id = $1 AND NOT EXISTS ("
      "SELECT 1 FROM frames WHERE sha256 = mine.sha256 AND flight_id <> $1) AND NOT EXISTS ("
      "SELECT 1 FROM photo_tiles WHERE sha256 = mine.sha256)";
  // Each row that is a second apart is one search of an index.
  dialect.recent_telemetry =
      "WITH RECURSIVE own AS NOT MATERIALIZED (SELECT timestamp_us, value_0, value_1, value_2, "
      "value_3, arrived_at_us FROM telemetry WHERE flight_id = $1 AND kind = $2), "
      "apart(at_us, number) AS (SELECT (SELECT max(arrived_at_us) FROM own), 1 UNION ALL "
      "SELECT (SELECT max(arrived_at_us) FROM own WHERE arrived_at_us <= at_us - 1000000), "
      "number + 1 FROM apart WHERE at_us IS NOT NULL AND number < $3) "
      "SELECT * FROM (SELECT * FROM own ORDER BY arrived_at_us DESC LIMIT $3) UNION "
      "SELECT timestamp_us, value_0, value_1, value_2, value_3, arrived_at_us FROM apart "
      "CROSS JOIN telemetry INDEXED BY telemetry_by_arrival "
      "ON flight_id = $1 AND kind = $2 AND arrived_at_us = at_us ORDER BY arrived_at_us";
  dialect.last_change = "SELECT number FROM feed";
  dialect.step_change = "UPDATE feed SET number = number + 1";
  dialect.new_change = "(SELECT number FROM feed)";
  dialect.can_follow = true;
  dialect.recallable_sites = "sites JOIN site_numbers ON site_id = sites.id";
  dialect.has_second_copy = true;
  return dialect;
}

}  // namespace freelsd
