#include <algorithm>

#include "storage/sqlite/arrivals.h"
#include "storage/sqlite/state.h"
#include "storage/sqlite/stores.h"

namespace freelsd {
namespace {

std::optional<TelemetryRow> NextRow(Statement& statement, TelemetryKind kind) {
  if (!statement.Step()) return std::nullopt;
  TelemetryRow row;
  row.kind = kind;
  row.timestamp_us = statement.Int(0);
  for (int i = 0; i < 4; ++i) row.values[static_cast<size_t>(i)] = statement.Real(i + 1);
  row.arrived_at_us = statement.Int(5);
  return row;
}

// Each row that is a second apart is one search of an index.
constexpr char kSelectRecent[] =
    "WITH RECURSIVE own AS NOT MATERIALIZED (SELECT timestamp_us, value_0, value_1, value_2, "
    "value_3, arrived_at_us FROM telemetry WHERE flight_id = ?1 AND kind = ?2), "
    "apart(at_us, number) AS (SELECT (SELECT max(arrived_at_us) FROM own), 1 UNION ALL "
    "SELECT (SELECT max(arrived_at_us) FROM own WHERE arrived_at_us <= at_us - 1000000), number + "
    "1 "
    "FROM apart WHERE at_us IS NOT NULL AND number < ?3) "
    "SELECT * FROM (SELECT * FROM own ORDER BY arrived_at_us DESC LIMIT ?3) UNION "
    "SELECT timestamp_us, value_0, value_1, value_2, value_3, arrived_at_us FROM apart "
    "CROSS JOIN telemetry INDEXED BY telemetry_by_arrival "
    "ON flight_id = ?1 AND kind = ?2 AND arrived_at_us = at_us ORDER BY arrived_at_us";

void PutSamples(const Connection& writer,
                const std::string& flight_id,
                const std::vector<TelemetryRow>& rows) {
  int64_t next_us = NextArrival(writer, flight_id);
  for (const TelemetryRow& row : rows) {
    const int64_t arrived_at_us = std::max(row.arrived_at_us, next_us);
    next_us = arrived_at_us + 1;
    writer.Prepare("INSERT OR REPLACE INTO telemetry VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)")
        .Bind(flight_id,
              static_cast<int>(row.kind),
              row.timestamp_us,
              row.values[0],
              row.values[1],
              row.values[2],
              row.values[3],
              arrived_at_us)
        .Run();
  }
}

}  // namespace

void SqliteTelemetryStore::PutTogether(const std::vector<Samples*>& group) {
  const auto lock = state_.LockForWriting();
  Transaction transaction(state_.writer);
  for (Samples* const each : group) {
    Statement flight = state_.writer.Prepare("SELECT 1 FROM flights WHERE id = ?1");
    each->has_flight = flight.Bind(each->flight_id).Step();
    if (each->has_flight) PutSamples(state_.writer, each->flight_id, each->rows);
  }
  transaction.Commit();
}

bool SqliteTelemetryStore::Put(const std::string& flight_id,
                               const std::vector<TelemetryRow>& rows) {
  Samples samples{flight_id, rows};
  grouped_.Run(samples, [this](const std::vector<Samples*>& group) { PutTogether(group); });
  return samples.has_flight;
}

std::vector<TelemetryRow> SqliteTelemetryStore::Recent(const std::string& flight_id,
                                                       TelemetryKind kind,
                                                       int max_num_rows) const {
  const Reader reader(state_.readers);
  Statement statement = reader->Prepare(kSelectRecent);
  statement.Bind(flight_id, static_cast<int>(kind), max_num_rows);
  std::vector<TelemetryRow> rows;
  while (const auto row = NextRow(statement, kind)) rows.push_back(*row);
  return rows;
}

TelemetryPair SqliteTelemetryStore::Around(const std::string& flight_id,
                                           TelemetryKind kind,
                                           int64_t timestamp_us) const {
  const Reader reader(state_.readers);
  Statement before = reader->Prepare(
      "SELECT timestamp_us, value_0, value_1, value_2, value_3, arrived_at_us FROM telemetry "
      "WHERE flight_id = ?1 AND kind = ?2 AND timestamp_us <= ?3 ORDER BY timestamp_us DESC LIMIT "
      "1");
  before.Bind(flight_id, static_cast<int>(kind), timestamp_us);
  Statement after = reader->Prepare(
      "SELECT timestamp_us, value_0, value_1, value_2, value_3, arrived_at_us FROM telemetry "
      "WHERE flight_id = ?1 AND kind = ?2 AND timestamp_us >= ?3 ORDER BY timestamp_us LIMIT 1");
  after.Bind(flight_id, static_cast<int>(kind), timestamp_us);
  return {NextRow(before, kind), NextRow(after, kind)};
}

}  // namespace freelsd
