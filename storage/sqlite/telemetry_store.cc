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

// `sql` selects the columns of NextRow, for flight, kind and limit.
std::vector<TelemetryRow> RowsOf(StorageState& state,
                                 const char* sql,
                                 const std::string& flight_id,
                                 TelemetryKind kind,
                                 int max_num_rows) {
  const Reader reader(state.readers);
  Statement statement = reader->Prepare(sql);
  statement.Bind(flight_id, static_cast<int>(kind), max_num_rows);
  std::vector<TelemetryRow> rows;
  while (const auto row = NextRow(statement, kind)) rows.push_back(*row);
  return rows;
}

constexpr char kLastArrived[] =
    "SELECT timestamp_us, value_0, value_1, value_2, value_3, arrived_at_us FROM telemetry "
    "WHERE flight_id = ?1 AND kind = ?2 ORDER BY arrived_at_us DESC LIMIT ?3";
constexpr char kFirstArrived[] =
    "SELECT timestamp_us, value_0, value_1, value_2, value_3, arrived_at_us FROM telemetry "
    "WHERE flight_id = ?1 AND kind = ?2 ORDER BY arrived_at_us LIMIT ?3";
constexpr char kLatest[] =
    "SELECT timestamp_us, value_0, value_1, value_2, value_3, arrived_at_us FROM telemetry "
    "WHERE flight_id = ?1 AND kind = ?2 ORDER BY timestamp_us DESC LIMIT ?3";

}  // namespace

bool SqliteTelemetryStore::Put(const std::string& flight_id,
                               const std::vector<TelemetryRow>& rows) {
  const auto lock = state_.LockForWriting();
  Transaction transaction(state_.writer);
  Statement flight = state_.writer.Prepare("SELECT 1 FROM flights WHERE id = ?1");
  if (!flight.Bind(flight_id).Step()) return false;
  int64_t next_us = NextArrival(state_.writer, flight_id);
  for (const TelemetryRow& row : rows) {
    const int64_t arrived_at_us = std::max(row.arrived_at_us, next_us);
    next_us = arrived_at_us + 1;
    state_.writer
        .Prepare("INSERT OR REPLACE INTO telemetry VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)")
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
  transaction.Commit();
  return true;
}

std::vector<TelemetryRow> SqliteTelemetryStore::LastArrived(const std::string& flight_id,
                                                            TelemetryKind kind,
                                                            int max_num_rows) const {
  return RowsOf(state_, kLastArrived, flight_id, kind, max_num_rows);
}

std::vector<TelemetryRow> SqliteTelemetryStore::Latest(const std::string& flight_id,
                                                       TelemetryKind kind,
                                                       int max_num_rows) const {
  return RowsOf(state_, kLatest, flight_id, kind, max_num_rows);
}

std::optional<TelemetryRow> SqliteTelemetryStore::FirstArrived(const std::string& flight_id,
                                                               TelemetryKind kind) const {
  const std::vector<TelemetryRow> rows = RowsOf(state_, kFirstArrived, flight_id, kind, 1);
  return rows.empty() ? std::nullopt : std::optional(rows.front());
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
