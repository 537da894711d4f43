#include <algorithm>

#include "storage/stores/stores.h"

namespace freelsd {
namespace {

std::string SelectTelemetry(const std::string& which) {
  return "SELECT timestamp_us, value_0, value_1, value_2, value_3, arrived_at_us FROM telemetry "
         "WHERE flight_id = $1 AND kind = $2 AND " +
         which;
}

// Of the samples of one flight with the same kind and time, the last one counts.
void AddWithArrivals(const std::string& flight_id,
                     const std::vector<TelemetryRow>& rows,
                     int64_t next_us,
                     std::vector<Sample>& samples) {
  std::map<std::pair<TelemetryKind, int64_t>, TelemetryRow> by_time;
  for (TelemetryRow row : rows) {
    row.arrived_at_us = std::max(row.arrived_at_us, next_us);
    next_us = row.arrived_at_us + 1;
    by_time[{row.kind, row.timestamp_us}] = row;
  }
  for (const auto& [time, row] : by_time) samples.emplace_back(flight_id, row);
}

// Makes rows of one kind.
auto RowsOf(TelemetryKind kind) {
  return [kind](const Row& row) {
    TelemetryRow sample;
    sample.kind = kind;
    sample.timestamp_us = row.Int(0);
    for (int i = 0; i < 4; ++i) sample.values[static_cast<size_t>(i)] = row.Real(i + 1);
    sample.arrived_at_us = row.Int(5);
    return sample;
  };
}

}  // namespace

// Flights that are there and that nobody else holds: who waits for one must not keep the others.
void SqlTelemetryStore::PutTogether(const std::vector<Given*>& group) {
  std::vector<std::string> ids;
  ids.reserve(group.size());
  for (const Given* const each : group) ids.push_back(each->flight_id);
  access_.Write([&](Writer& writer) {
    const std::map<std::string, int64_t> locked = queries_.lock_free_flights(*writer, ids);
    std::map<std::string, std::vector<TelemetryRow>> rows_of;
    for (Given* const each : group) {
      each->is_stored = locked.contains(each->flight_id);
      if (!each->is_stored) continue;
      std::vector<TelemetryRow>& rows = rows_of[each->flight_id];
      rows.insert(rows.end(), each->rows.begin(), each->rows.end());
    }
    std::vector<Sample> samples;
    for (const auto& [id, next_us] : locked) AddWithArrivals(id, rows_of[id], next_us, samples);
    if (!samples.empty()) queries_.put(*writer, samples);
  });
}

bool SqlTelemetryStore::PutAlone(const std::string& flight_id,
                                 const std::vector<TelemetryRow>& rows) {
  return access_.Write([&](Writer& writer) {
    if (!LockFlight(*writer, flight_id)) return false;
    std::vector<Sample> samples;
    AddWithArrivals(flight_id, rows, NextArrival(*writer, flight_id), samples);
    queries_.put(*writer, samples);
    return true;
  });
}

bool SqlTelemetryStore::Put(const std::string& flight_id, const std::vector<TelemetryRow>& rows) {
  Given given{flight_id, rows};
  grouped_.Run(given, [this](const std::vector<Given*>& group) { PutTogether(group); });
  return given.is_stored || PutAlone(flight_id, rows);
}

std::vector<TelemetryRow> SqlTelemetryStore::Recent(const std::string& flight_id,
                                                    TelemetryKind kind,
                                                    int max_num_rows) const {
  return access_.Read([&](Database& database) {
    return database.Each(RowsOf(kind),
                         access_.dialect().recent_telemetry,
                         flight_id,
                         static_cast<int>(kind),
                         max_num_rows);
  });
}

TelemetryPair SqlTelemetryStore::Around(const std::string& flight_id,
                                        TelemetryKind kind,
                                        int64_t timestamp_us) const {
  return access_.Read([&](Database& database) {
    const auto find = [&](const std::string& which) {
      return database.First(
          RowsOf(kind), SelectTelemetry(which), flight_id, static_cast<int>(kind), timestamp_us);
    };
    return TelemetryPair{find("timestamp_us <= $3 ORDER BY timestamp_us DESC LIMIT 1"),
                         find("timestamp_us >= $3 ORDER BY timestamp_us LIMIT 1")};
  });
}

}  // namespace freelsd
