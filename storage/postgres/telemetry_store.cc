#include <algorithm>
#include <map>
#include <utility>

#include "storage/postgres/flight_rows.h"
#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

constexpr char kSelectTelemetry[] =
    "SELECT timestamp_us, value_0, value_1, value_2, value_3, arrived_at_us, kind FROM telemetry ";

TelemetryRow TelemetryRowOf(const PostgresRow& row) {
  TelemetryRow sample;
  sample.timestamp_us = row.Int(0);
  for (int i = 0; i < 4; ++i) sample.values[static_cast<size_t>(i)] = row.Real(i + 1);
  sample.arrived_at_us = row.Int(5);
  sample.kind = static_cast<TelemetryKind>(row.Int(6));
  return sample;
}

std::optional<TelemetryRow> FirstSample(const PostgresRows& rows) {
  if (rows.empty()) return std::nullopt;
  return TelemetryRowOf(rows[0]);
}

std::vector<TelemetryRow> RowsOf(PostgresState& state,
                                 const std::string& order,
                                 const std::string& flight_id,
                                 TelemetryKind kind,
                                 int max_num_rows) {
  return state.Read([&](PostgresConnection& connection) {
    return connection
        .Run(kSelectTelemetry + ("WHERE flight_id = $1 AND kind = $2 ORDER BY " + order) +
                 " LIMIT $3",
             flight_id,
             static_cast<int>(kind),
             max_num_rows)
        .Each(TelemetryRowOf);
  });
}

// A statement may write a row only once: of samples with the same time, the last one counts.
std::vector<TelemetryRow> WithArrivals(const std::vector<TelemetryRow>& rows, int64_t next_us) {
  std::map<std::pair<TelemetryKind, int64_t>, TelemetryRow> by_time;
  for (TelemetryRow row : rows) {
    row.arrived_at_us = std::max(row.arrived_at_us, next_us);
    next_us = row.arrived_at_us + 1;
    by_time[{row.kind, row.timestamp_us}] = row;
  }
  std::vector<TelemetryRow> last;
  last.reserve(by_time.size());
  for (const auto& [time, row] : by_time) last.push_back(row);
  return last;
}

void PutSamples(PostgresConnection& writer,
                const std::string& flight_id,
                const std::vector<TelemetryRow>& rows) {
  std::vector<int64_t> kinds, timestamps_us, arrivals_us;
  std::array<std::vector<double>, 4> values;
  for (const TelemetryRow& row : rows) {
    kinds.push_back(static_cast<int64_t>(row.kind));
    timestamps_us.push_back(row.timestamp_us);
    arrivals_us.push_back(row.arrived_at_us);
    for (size_t i = 0; i < values.size(); ++i) values[i].push_back(row.values[i]);
  }
  writer.Run(
      "INSERT INTO telemetry (flight_id, kind, timestamp_us, value_0, value_1, value_2, value_3, "
      "arrived_at_us) SELECT $1, * FROM unnest($2, $3, $4, $5, $6, $7, $8) "
      "ON CONFLICT (flight_id, kind, timestamp_us) DO UPDATE SET value_0 = excluded.value_0, "
      "value_1 = excluded.value_1, value_2 = excluded.value_2, value_3 = excluded.value_3, "
      "arrived_at_us = excluded.arrived_at_us",
      flight_id,
      kinds,
      timestamps_us,
      values[0],
      values[1],
      values[2],
      values[3],
      arrivals_us);
}

}  // namespace

bool PostgresTelemetryStore::Put(const std::string& flight_id,
                                 const std::vector<TelemetryRow>& rows) {
  PostgresWrite writer(state_);
  if (!LockFlight(*writer, flight_id)) return false;
  PutSamples(*writer, flight_id, WithArrivals(rows, NextArrivalOf(*writer, flight_id)));
  writer.Commit();
  return true;
}

std::vector<TelemetryRow> PostgresTelemetryStore::LastArrived(const std::string& flight_id,
                                                              TelemetryKind kind,
                                                              int max_num_rows) const {
  return RowsOf(state_, "arrived_at_us DESC", flight_id, kind, max_num_rows);
}

std::vector<TelemetryRow> PostgresTelemetryStore::Latest(const std::string& flight_id,
                                                         TelemetryKind kind,
                                                         int max_num_rows) const {
  return RowsOf(state_, "timestamp_us DESC", flight_id, kind, max_num_rows);
}

std::optional<TelemetryRow> PostgresTelemetryStore::FirstArrived(const std::string& flight_id,
                                                                 TelemetryKind kind) const {
  const std::vector<TelemetryRow> rows = RowsOf(state_, "arrived_at_us", flight_id, kind, 1);
  return rows.empty() ? std::nullopt : std::optional(rows.front());
}

TelemetryPair PostgresTelemetryStore::Around(const std::string& flight_id,
                                             TelemetryKind kind,
                                             int64_t timestamp_us) const {
  return state_.Read([&](PostgresConnection& connection) {
    TelemetryPair pair;
    pair.before = FirstSample(connection.Run(
        std::string(kSelectTelemetry) + "WHERE flight_id = $1 AND kind = $2 AND timestamp_us <= $3 "
                                        "ORDER BY timestamp_us DESC LIMIT 1",
        flight_id,
        static_cast<int>(kind),
        timestamp_us));
    pair.after = FirstSample(connection.Run(
        std::string(kSelectTelemetry) + "WHERE flight_id = $1 AND kind = $2 AND timestamp_us >= $3 "
                                        "ORDER BY timestamp_us LIMIT 1",
        flight_id,
        static_cast<int>(kind),
        timestamp_us));
    return pair;
  });
}

}  // namespace freelsd
