#include "storage/telemetry_store.h"

#include "storage/sqlite/state.h"

namespace freelsd {
namespace {

std::optional<TelemetryRow> FirstRow(Statement& statement, TelemetryKind kind) {
  if (!statement.Step()) return std::nullopt;
  TelemetryRow row;
  row.kind = kind;
  row.timestamp_us = statement.Int(0);
  for (int i = 0; i < 4; ++i) row.values[static_cast<size_t>(i)] = statement.Real(i + 1);
  return row;
}

}  // namespace

bool TelemetryStore::Put(const std::string& flight_id, const std::vector<TelemetryRow>& rows) {
  const auto lock = state_.LockForWriting();
  Transaction transaction(state_.writer);
  Statement flight = state_.writer.Prepare("SELECT 1 FROM flights WHERE id = ?1");
  if (!flight.Bind(flight_id).Step()) return false;
  for (const TelemetryRow& row : rows) {
    state_.writer.Prepare("INSERT OR REPLACE INTO telemetry VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)")
        .Bind(flight_id,
              static_cast<int>(row.kind),
              row.timestamp_us,
              row.values[0],
              row.values[1],
              row.values[2],
              row.values[3])
        .Run();
  }
  transaction.Commit();
  return true;
}

TelemetryPair TelemetryStore::Around(const std::string& flight_id,
                                     TelemetryKind kind,
                                     int64_t timestamp_us) const {
  const Reader reader(state_.readers);
  Statement before = reader->Prepare(
      "SELECT timestamp_us, value_0, value_1, value_2, value_3 FROM telemetry WHERE flight_id = ?1 "
      "AND kind = ?2 AND timestamp_us <= ?3 ORDER BY timestamp_us DESC LIMIT 1");
  before.Bind(flight_id, static_cast<int>(kind), timestamp_us);
  Statement after = reader->Prepare(
      "SELECT timestamp_us, value_0, value_1, value_2, value_3 FROM telemetry WHERE flight_id = ?1 "
      "AND kind = ?2 AND timestamp_us >= ?3 ORDER BY timestamp_us LIMIT 1");
  after.Bind(flight_id, static_cast<int>(kind), timestamp_us);
  return {FirstRow(before, kind), FirstRow(after, kind)};
}

}  // namespace freelsd
