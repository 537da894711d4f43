#include "storage/postgres/dialect.h"

#include <array>
#include <limits>
#include <set>

#include "storage/postgres/area_rows.h"
#include "storage/postgres/connection.h"

namespace freelsd {
namespace {

std::map<std::string, int64_t> NextArrivalsOf(PostgresConnection& writer,
                                              const std::vector<std::string>& flight_ids) {
  // As NextArrival.
  const PostgresRows rows = writer.Run(
      "SELECT flight, greatest("
      "(SELECT max(arrived_at_us) FROM telemetry WHERE flight_id = flight AND kind = 0), "
      "(SELECT max(arrived_at_us) FROM telemetry WHERE flight_id = flight AND kind = 1), "
      "(SELECT max(arrived_at_us) FROM telemetry WHERE flight_id = flight AND kind = 2), "
      "(SELECT arrived_at_us FROM frames WHERE flight_id = flight ORDER BY sequence DESC LIMIT 1)) "
      "FROM unnest($1) AS flight",
      flight_ids);
  std::map<std::string, int64_t> next;
  for (int i = 0; i < rows.size(); ++i) {
    const std::optional<int64_t> last = rows[i].OptionalInt(1);
    next[rows[i].Text(0)] = last ? *last + 1 : std::numeric_limits<int64_t>::min();
  }
  return next;
}

std::map<std::string, int64_t> LockFreeFlights(Database& database,
                                               const std::vector<std::string>& flight_ids) {
  PostgresConnection& writer = PostgresOf(database);
  const std::vector<std::string> locked =
      writer
          .Run(
              "SELECT id FROM flights WHERE id = ANY($1) ORDER BY id FOR NO KEY UPDATE SKIP LOCKED",
              flight_ids)
          .Texts();
  if (locked.empty()) return {};
  return NextArrivalsOf(writer, locked);
}

// In one statement.
void PutSamples(Database& writer, const std::vector<Sample>& samples) {
  std::vector<std::string> flight_ids;
  std::vector<int64_t> kinds, timestamps_us, arrivals_us;
  std::array<std::vector<double>, 4> values;
  for (const auto& [flight_id, row] : samples) {
    flight_ids.push_back(flight_id);
    kinds.push_back(static_cast<int64_t>(row.kind));
    timestamps_us.push_back(row.timestamp_us);
    arrivals_us.push_back(row.arrived_at_us);
    for (size_t i = 0; i < values.size(); ++i) values[i].push_back(row.values[i]);
  }
  PostgresOf(writer).Run(
      "INSERT INTO telemetry (flight_id, kind, timestamp_us, value_0, value_1, value_2, value_3, "
      "arrived_at_us) SELECT * FROM unnest($1, $2, $3, $4, $5, $6, $7, $8) "
      "ON CONFLICT (flight_id, kind, timestamp_us) DO UPDATE SET value_0 = excluded.value_0, "
      "value_1 = excluded.value_1, value_2 = excluded.value_2, value_3 = excluded.value_3, "
      "arrived_at_us = excluded.arrived_at_us",
      flight_ids,
      kinds,
      timestamps_us,
      values[0],
      values[1],
      values[2],
      values[3],
      arrivals_us);
}

void PutAreaOf(Database& writer, const FlightMapRow& map) {
  PutArea(PostgresOf(writer), "map", map.id, map.box);
}

// Rows of images whose files come later, in one order for all who lock several.
void PutImagesToCome(Database& writer, const PhotoTiles& photo_tiles) {
  std::set<std::string> images;
  for (const auto& [key, sha256] : photo_tiles) images.insert(sha256);
  for (const std::string& sha256 : images) {
    // Locks the row, also where it is already there: nobody removes it before the commit.
    writer.Change(
        "INSERT INTO images (sha256, num_bytes) VALUES ($1, 0) "
        "ON CONFLICT (sha256) DO UPDATE SET num_bytes = images.num_bytes",
        sha256);
  }
}

// Others on a shared database may be receiving the flight's next frame.
std::string FlightInUse(bool is_shared) {
  const std::string quiet_us = "(extract(epoch FROM clock_timestamp()) - 600) * 1000000";
  return "SELECT 1 WHERE EXISTS (SELECT 1 FROM frames WHERE flight_id = $1 AND (state = 0" +
         (is_shared ? " OR arrived_at_us > " + quiet_us : "") +
         ")) OR EXISTS (SELECT 1 FROM jobs WHERE flight_id = $1 AND state < 2)" +
         (is_shared ? " OR EXISTS (SELECT 1 FROM flights WHERE id = $1 AND created_at_us > " +
                          quiet_us + ")"
                    : "");
}

}  // namespace

const TelemetryQueries kPostgresTelemetry{LockFreeFlights, PutSamples};
const SqlMapStore::Queries kPostgresMaps{PutAreaOf, PutImagesToCome};

Dialect PostgresDialect(bool is_shared) {
  Dialect dialect;
  dialect.flight_number = "number";
  dialect.flight_in_use = FlightInUse(is_shared);
  dialect.frame_image = "stored_image";
  dialect.retired_images =
      "SELECT DISTINCT stored_image FROM frames WHERE flight_id = $1 AND stored_image IS NOT NULL";
  dialect.retire_images = "UPDATE frames SET stored_image = NULL WHERE flight_id = $1";
  dialect.forget_lost_workers =
      "UPDATE claims SET num_lost = 0 WHERE flight_id = $1 AND num_lost > 0";
  // Each row that is a second apart is one search of an index.
  dialect.recent_telemetry =
      "WITH RECURSIVE own AS NOT MATERIALIZED (SELECT timestamp_us, value_0, value_1, value_2, "
      "value_3, arrived_at_us FROM telemetry WHERE flight_id = $1 AND kind = $2), "
      "apart(at_us, number) AS (SELECT (SELECT max(arrived_at_us) FROM own), 1 UNION ALL "
      "SELECT (SELECT max(arrived_at_us) FROM own WHERE arrived_at_us <= at_us - 1000000), "
      "number + 1 FROM apart WHERE at_us IS NOT NULL AND number < $3) "
      "SELECT * FROM ((SELECT * FROM own ORDER BY arrived_at_us DESC LIMIT $3) UNION "
      "SELECT sample.* FROM apart CROSS JOIN LATERAL (SELECT * FROM own WHERE arrived_at_us = "
      "at_us "
      "LIMIT 1) AS sample) AS recent ORDER BY arrived_at_us";
  dialect.last_change =
      "SELECT greatest((SELECT max(number) FROM changes), (SELECT forgotten_through FROM feed))";
  // Holds the row that orders the numbers.
  dialect.lock_changes = "SELECT 1 FROM versions WHERE name = 'sites' FOR NO KEY UPDATE";
  dialect.new_change = "nextval('change_numbers')";
  dialect.recallable_sites = "sites";
  return dialect;
}

}  // namespace freelsd
