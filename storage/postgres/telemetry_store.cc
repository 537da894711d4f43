#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "storage/postgres/flight_rows.h"
#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

constexpr char kSelectTelemetry[] =
    "SELECT timestamp_us, value_0, value_1, value_2, value_3, arrived_at_us, kind FROM telemetry ";

// Each row that is a second apart is one search of an index.
constexpr char kSelectRecent[] =
    "WITH RECURSIVE own AS NOT MATERIALIZED (SELECT timestamp_us, value_0, value_1, value_2, "
    "value_3, arrived_at_us, kind FROM telemetry WHERE flight_id = $1 AND kind = $2), "
    "apart(at_us, number) AS (SELECT (SELECT max(arrived_at_us) FROM own), 1 UNION ALL "
    "SELECT (SELECT max(arrived_at_us) FROM own WHERE arrived_at_us <= at_us - 1000000), number + "
    "1 "
    "FROM apart WHERE at_us IS NOT NULL AND number < $3) "
    "SELECT * FROM ((SELECT * FROM own ORDER BY arrived_at_us DESC LIMIT $3) UNION "
    "SELECT sample.* FROM apart CROSS JOIN LATERAL (SELECT * FROM own WHERE arrived_at_us = at_us "
    "LIMIT 1) AS sample) AS recent ORDER BY arrived_at_us";

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

// Columns of the table, to be unnested.
struct SampleColumns {
  std::vector<std::string> flight_ids;
  std::vector<int64_t> kinds, timestamps_us, arrivals_us;
  std::array<std::vector<double>, 4> values;

  void Add(const std::string& flight_id, const TelemetryRow& row) {
    flight_ids.push_back(flight_id);
    kinds.push_back(static_cast<int64_t>(row.kind));
    timestamps_us.push_back(row.timestamp_us);
    arrivals_us.push_back(row.arrived_at_us);
    for (size_t i = 0; i < values.size(); ++i) values[i].push_back(row.values[i]);
  }
};

// A statement may write a row only once: of samples with the same time, the last one counts.
void AddWithArrivals(const std::string& flight_id,
                     const std::vector<TelemetryRow>& rows,
                     int64_t next_us,
                     SampleColumns& columns) {
  std::map<std::pair<TelemetryKind, int64_t>, TelemetryRow> by_time;
  for (TelemetryRow row : rows) {
    row.arrived_at_us = std::max(row.arrived_at_us, next_us);
    next_us = row.arrived_at_us + 1;
    by_time[{row.kind, row.timestamp_us}] = row;
  }
  for (const auto& [time, row] : by_time) columns.Add(flight_id, row);
}

void PutSamples(PostgresConnection& writer, const SampleColumns& columns) {
  writer.Run(
      "INSERT INTO telemetry (flight_id, kind, timestamp_us, value_0, value_1, value_2, value_3, "
      "arrived_at_us) SELECT * FROM unnest($1, $2, $3, $4, $5, $6, $7, $8) "
      "ON CONFLICT (flight_id, kind, timestamp_us) DO UPDATE SET value_0 = excluded.value_0, "
      "value_1 = excluded.value_1, value_2 = excluded.value_2, value_3 = excluded.value_3, "
      "arrived_at_us = excluded.arrived_at_us",
      columns.flight_ids,
      columns.kinds,
      columns.timestamps_us,
      columns.values[0],
      columns.values[1],
      columns.values[2],
      columns.values[3],
      columns.arrivals_us);
}

bool PutAlone(PostgresState& state,
              const std::string& flight_id,
              const std::vector<TelemetryRow>& rows) {
  PostgresWrite writer(state);
  if (!LockFlight(*writer, flight_id)) return false;
  SampleColumns columns;
  AddWithArrivals(flight_id, rows, NextArrivalsOf(*writer, {flight_id}).at(flight_id), columns);
  PutSamples(*writer, columns);
  writer.Commit();
  return true;
}

}  // namespace

// Flights that are there and that nobody else holds: who waits for one must not keep the others.
void PostgresTelemetryStore::PutTogether(const std::vector<Samples*>& group) {
  PostgresWrite writer(state_);
  std::map<std::string, std::vector<TelemetryRow>> rows_of;
  std::vector<std::string> ids;
  ids.reserve(group.size());
  for (const Samples* const each : group) ids.push_back(each->flight_id);
  const std::vector<std::string> locked = LockFreeFlights(*writer, ids);
  const std::set<std::string> is_locked(locked.begin(), locked.end());
  for (Samples* const each : group) {
    each->is_stored = is_locked.contains(each->flight_id);
    if (!each->is_stored) continue;
    std::vector<TelemetryRow>& rows = rows_of[each->flight_id];
    rows.insert(rows.end(), each->rows.begin(), each->rows.end());
  }
  if (locked.empty()) return;
  SampleColumns columns;
  for (const auto& [flight_id, next_us] : NextArrivalsOf(*writer, locked)) {
    AddWithArrivals(flight_id, rows_of[flight_id], next_us, columns);
  }
  PutSamples(*writer, columns);
  writer.Commit();
}

bool PostgresTelemetryStore::Put(const std::string& flight_id,
                                 const std::vector<TelemetryRow>& rows) {
  Samples samples{flight_id, rows};
  grouped_.Run(samples, [this](const std::vector<Samples*>& group) { PutTogether(group); });
  return samples.is_stored || PutAlone(state_, flight_id, rows);
}

std::vector<TelemetryRow> PostgresTelemetryStore::Recent(const std::string& flight_id,
                                                         TelemetryKind kind,
                                                         int max_num_rows) const {
  return state_.Read([&](PostgresConnection& connection) {
    return connection.Run(kSelectRecent, flight_id, static_cast<int>(kind), max_num_rows)
        .Each(TelemetryRowOf);
  });
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
